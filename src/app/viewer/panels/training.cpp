// SPDX-License-Identifier: MIT
//
// Training in the window: its progress, the curve of the loss, and buttons.
#include <algorithm>
#include <vector>

#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/training_actions.h"

namespace qs {
namespace {

void draw_loss(const Training& training) {
  if (training.losses.size() < 2) return;
  const std::vector<float> losses(training.losses.begin(), training.losses.end());
  const float largest = *std::max_element(losses.begin(), losses.end());
  ImGui::PlotLines("##loss", losses.data(), static_cast<int>(losses.size()), 0, nullptr, 0, largest,
                   {ImGui::GetContentRegionAvail().x, 6 * ImGui::GetFontSize()});
  ImGui::TextColored(palette::kFaint, "%s", loss_plot_text(training).c_str());
}

}  // namespace

void draw_training(const Viewer& viewer, PanelState&, Actions& actions) {
  if (!viewer.training) {
    ImGui::TextWrapped("Nothing is trained. File > Train from photographs starts a run.");
    return;
  }
  const Training& training = *viewer.training;
  const TrainingProgress& progress = training.progress;
  if (progress.iterations > 0) {
    ImGui::ProgressBar(
        static_cast<float>(progress.iteration) / static_cast<float>(progress.iterations), {-1, 0});
  }
  for (const Fact& fact : training_facts(viewer)) draw_fact(fact);
  draw_loss(training);
  if (training.phase == TrainingPhase::ended) return;
  const bool paused = training.phase == TrainingPhase::paused;
  if (ImGui::Button(paused ? "Resume" : "Pause")) actions.push_back(call(action::toggle_training));
  command_tooltip("Pause or resume training");
  const auto button = [&](const char* title, TrainingCommand command, const char* tooltip) {
    same_line_if_fits(ImGui::CalcTextSize(title).x);
    if (ImGui::Button(title)) actions.push_back(call(action::command_training, command));
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tooltip);
  };
  button("Step", TrainingCommand::step, "Pauses, or trains one more iteration");
  button("Save", TrainingCommand::save, "Saves the model and goes on");
  button("Stop", TrainingCommand::stop, "Saves the model and ends the run; --resume continues it");
}

}  // namespace qs
