// SPDX-License-Identifier: MIT
//
// Training in the window: its progress, buttons, a test view, and the curve of the loss.
#include <cmath>
#include <vector>

#include <imgui.h>

#include "app/viewer/panels/controls_drawer.h"
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

void draw_training_buttons(const ControlsDrawer& controls) {
  controls.draw("Pause training");
  for (const char* name : {"Step", "Save the model", "Stop training"}) controls.draw_after(name);
}

}  // namespace

void draw_training(const Viewer& viewer, PanelState& state, Actions& actions) {
  const ControlsDrawer controls(viewer, actions);
  if (viewer.remote) {
    controls.draw("Pause training");
    for (const Fact& fact : remote_facts(viewer)) draw_fact(fact);
    return;
  }
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
  if (training.phase != TrainingPhase::ended) draw_training_buttons(controls);
  draw_test_view(viewer, state, actions);
  for (const Fact& fact : training_facts(viewer)) draw_fact(fact);
  draw_loss(training.losses);
}

}  // namespace qs
