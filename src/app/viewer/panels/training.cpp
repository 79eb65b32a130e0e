// SPDX-License-Identifier: MIT
//
// Training in the window: its progress, buttons, a test view, and the curve of the loss.
#include <cmath>
#include <vector>

#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/plot_axes.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/loss_chart.h"
#include "app/viewer/state/remote_actions.h"
#include "app/viewer/state/training_actions.h"

namespace qs {
namespace {

void draw_loss(const std::vector<LossPoint>& losses) {
  if (losses.size() < 2) return;
  const LossChart chart = loss_chart(losses);
  PlotAxes axes{{}, {}, kIterationTitle};
  for (const AxisTick& tick : chart.iteration_ticks)
    axes.across.push_back({static_cast<float>(tick.value / chart.most_iteration), tick.text});
  for (const AxisTick& tick : chart.loss_ticks)
    axes.up.push_back({static_cast<float>(tick.value / chart.most_loss), tick.text});
  ImGui::TextColored(palette::kFaint, "%s", kLossTitle);
  const PlotArea area = draw_plot_axes("loss", axes, 10 * ImGui::GetFontSize());
  if (ImGui::IsItemHovered()) {
    const LossPoint& near = loss_near(losses, area.mouse_x() * chart.most_iteration);
    ImGui::SetTooltip("iteration %d: loss %.4f", near.iteration, static_cast<double>(near.loss));
  }
  std::vector<ImVec2> points;
  for (const LossPoint& point : losses) {
    if (std::isfinite(point.loss))
      points.push_back(area.at({point.iteration / chart.most_iteration,
                                static_cast<double>(point.loss) / chart.most_loss}));
  }
  ImGui::GetWindowDrawList()->AddPolyline(points.data(), static_cast<int>(points.size()),
                                          ImGui::GetColorU32(palette::kAccent), 0,
                                          1.5f * drawing_scale());
}

void draw_training_buttons(const Training& training, Actions& actions) {
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

// A training in another program.
void draw_remote_training(const Viewer& viewer, Actions& actions) {
  if (ImGui::Button(viewer.remote->paused ? "Resume" : "Pause"))
    actions.push_back(call(action::toggle_training));
  command_tooltip("Pause or resume training");
  for (const Fact& fact : remote_facts(viewer)) draw_fact(fact);
}

}  // namespace

void draw_training(const Viewer& viewer, PanelState& state, Actions& actions) {
  if (viewer.remote) return draw_remote_training(viewer, actions);
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
  if (training.phase != TrainingPhase::ended) draw_training_buttons(training, actions);
  draw_test_view(viewer, state, actions);
  for (const Fact& fact : training_facts(viewer)) draw_fact(fact);
  draw_loss(training.losses);
}

}  // namespace qs
