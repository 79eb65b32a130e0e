// SPDX-License-Identifier: MIT
//
// The zoom recorder: the plan of a recording, the chart of all modes against the zoom, and the list
// of recordings.
#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/panels/zoom_drawing.h"
#include "app/viewer/state/zoom_actions.h"
#include "app/viewer/state/zoom_text.h"

namespace qs {
namespace {

void faint_text(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, palette::kFaint);
  ImGui::TextWrapped("%s", text.c_str());
  ImGui::PopStyleColor();
}

// A button at the end of the line, or on the next line if it does not fit.
bool button_after(const char* label, const char* tooltip) {
  same_line_if_fits(ImGui::CalcTextSize(label).x + 2 * ImGui::GetStyle().FramePadding.x);
  const bool is_pressed = ImGui::SmallButton(label);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tooltip);
  return is_pressed;
}

// ---- the plan ----------------------------------------------------------------------------------
void draw_ends(ZoomPlan& plan, Actions& actions) {
  ImGui::AlignTextToFramePadding();
  if (!plan.start) {
    ImGui::TextUnformatted("from this view");
    if (button_after("start here", "remembers this view as the start of recordings"))
      actions.push_back(call(action::start_zoom_here));
  } else {
    ImGui::TextUnformatted("from a remembered view");
    if (button_after("this view", "starts at the view in the window when Record is pressed"))
      actions.push_back(call(action::forget_zoom_start));
  }
  auto closer = static_cast<float>(plan.closer);
  ImGui::SetNextItemWidth(5 * ImGui::GetFontSize());
  if (ImGui::DragFloat("x closer", &closer, 0.2f, static_cast<float>(kLeastCloser),
                       static_cast<float>(kMostCloser), "%.4g", ImGuiSliderFlags_Logarithmic))
    plan.closer = static_cast<double>(closer);
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("the camera moves straight to the point in the middle of the first picture");
  ImGui::BeginDisabled(!plan.start.has_value());
  if (button_after("end here", "ends at the distance of this view from the target"))
    actions.push_back(call(action::end_zoom_here));
  ImGui::EndDisabled();
}

std::string size_text(const Viewer& viewer, glm::ivec2 size) {
  if (size.x > 0) return fmt::format("{} x {}", size.x, size.y);
  return fmt::format("as the window, {} x {}", viewer.camera.width, viewer.camera.height);
}

void draw_size_and_pipeline(const Viewer& viewer, ZoomPlan& plan) {
  ImGui::SetNextItemWidth(14 * ImGui::GetFontSize());
  if (ImGui::BeginCombo("size", size_text(viewer, plan.size).c_str())) {
    for (const glm::ivec2 size : kZoomSizes) {
      if (ImGui::Selectable(size_text(viewer, size).c_str(), size == plan.size)) plan.size = size;
    }
    ImGui::EndCombo();
  }
  const auto pipelines = pipelines_of(viewer.backend);
  if (pipelines.size() < 2) return;
  const Pipeline now = plan.pipeline.value_or(viewer.settings.pipeline);
  ImGui::SetNextItemWidth(14 * ImGui::GetFontSize());
  if (!ImGui::BeginCombo("pipeline", kPipelineNames[static_cast<int>(now)])) return;
  for (const Pipeline pipeline : pipelines) {
    if (ImGui::Selectable(kPipelineNames[static_cast<int>(pipeline)], pipeline == now))
      plan.pipeline = pipeline;
  }
  ImGui::EndCombo();
}

// The last mode cannot be switched off.
void draw_mode_choice(ZoomPlan& plan) {
  std::vector<CullMode> modes = zoom_modes(plan);
  const float box = ImGui::GetFrameHeight() + ImGui::GetStyle().ItemInnerSpacing.x;
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    if (mode > 1) same_line_if_fits(box + ImGui::CalcTextSize(mode_name(mode)).x);
    const auto found = std::find(modes.begin(), modes.end(), mode);
    bool is_chosen = found != modes.end();
    ImGui::PushStyleColor(ImGuiCol_Text, zoom_color(mode));
    if (ImGui::Checkbox(mode_name(mode), &is_chosen)) {
      if (is_chosen) {
        modes.push_back(mode);
      } else if (modes.size() > 1) {
        modes.erase(found);
      }
      plan.modes = modes;
    }
    ImGui::PopStyleColor();
  }
}

void draw_plan(const Viewer& viewer, Actions& actions) {
  ZoomPlan plan = viewer.zoom.plan;
  ImGui::BeginDisabled(viewer.zoom.running);
  draw_ends(plan, actions);
  ImGui::SetNextItemWidth(7 * ImGui::GetFontSize());
  ImGui::InputInt("steps", &plan.steps);
  ImGui::SetNextItemWidth(7 * ImGui::GetFontSize());
  ImGui::InputInt("frames per mode and step", &plan.frames, 10);
  draw_size_and_pipeline(viewer, plan);
  draw_mode_choice(plan);
  ImGui::EndDisabled();
  if (plan != viewer.zoom.plan) actions.push_back(call(action::change_zoom_plan, plan));
}

// ---- the chart ---------------------------------------------------------------------------------
void draw_quantities(const ZoomRecorder& zoom, Actions& actions) {
  for (std::size_t i = 0; i < std::size(kZoomQuantities); ++i) {
    const auto quantity = static_cast<ZoomQuantity>(i);
    if (i > 0) ImGui::SameLine();
    if (ImGui::RadioButton(kZoomQuantities[i].name, zoom.quantity == quantity))
      actions.push_back(call(action::show_zoom_quantity, quantity));
  }
}

void draw_zoom_legend(const ZoomChart& chart) {
  bool is_first = true;
  for (const ZoomCurve& curve : chart.curves) {
    if (curve.is_beneath) continue;
    if (!std::exchange(is_first, false))
      same_line_if_fits(ImGui::CalcTextSize(mode_name(curve.mode)).x);
    ImGui::TextColored(zoom_color(curve.mode), "%s", mode_name(curve.mode));
  }
}

void draw_shown_zoom(const ZoomRecorder& zoom, Actions& actions) {
  const ZoomRecord* record = shown_zoom(zoom);
  if (record == nullptr) return;
  const ZoomRecord* beneath = zoom_beneath(zoom);
  const ZoomChart chart = zoom_chart(record, beneath, zoom.quantity);
  if (!chart.empty()) {
    draw_quantities(zoom, actions);
    faint_text(chart.title);
    draw_zoom_chart(chart);
    draw_zoom_legend(chart);
  }
  faint_text(zoom_label(*record));
  if (beneath != nullptr) faint_text("dashed: " + zoom_label(*beneath));
  if (const std::string trust = zoom_trust_text(*record); !trust.empty()) faint_text(trust);
  if (zoom.running) return;
  faint_text(zoom_status(zoom));
  if (record->folder.empty()) return;
  if (ImGui::SmallButton("Open folder")) actions.push_back(call(action::open_zoom_folder));
  if (button_after("Copy figure", "copies the path of the plot of this quantity, a PNG file"))
    actions.push_back(call(action::copy_zoom_figure));
}

// ---- the recordings ----------------------------------------------------------------------------
void draw_recording(const ZoomRecorder& zoom, std::size_t index, Actions& actions) {
  const ZoomRecord& record = zoom.records[index];
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  if (ImGui::Selectable(zoom_title(record).c_str(), zoom.shown == index))
    actions.push_back(call(action::show_zoom, index));
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", zoom_label(record).c_str());
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(record.pipeline.c_str());
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(record.machine.c_str());
  ImGui::TableNextColumn();
  if (!zoom.shown || zoom.shown == index) return;
  const bool is_beneath = zoom.beneath == index;
  if (ImGui::SmallButton(is_beneath ? "hide" : "dashed"))
    actions.push_back(call(action::lay_zoom_beneath, index));
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("draws this recording dashed under the other");
}

void draw_recordings(const ZoomRecorder& zoom, Actions& actions) {
  if (zoom.records.empty()) return;
  ImGui::Separator();
  faint_text("recordings: a click shows one");
  constexpr int kColumns = 4;
  if (!ImGui::BeginTable("recordings", kColumns, ImGuiTableFlags_RowBg)) return;
  const float letter = ImGui::GetFontSize();
  ImGui::TableSetupColumn("recording", ImGuiTableColumnFlags_WidthFixed, 8 * letter);
  ImGui::TableSetupColumn("pipeline", ImGuiTableColumnFlags_WidthFixed, 3.2f * letter);
  ImGui::TableSetupColumn("machine", ImGuiTableColumnFlags_WidthStretch);
  ImGui::TableSetupColumn("dashed", ImGuiTableColumnFlags_WidthFixed, 3.6f * letter);
  for (std::size_t i = zoom.records.size(); i-- > 0;) {
    ImGui::PushID(static_cast<int>(i));
    draw_recording(zoom, i, actions);
    ImGui::PopID();
  }
  ImGui::EndTable();
}

}  // namespace

void draw_recorder(const Viewer& viewer, PanelState&, Actions& actions) {
  const ZoomRecorder& zoom = viewer.zoom;
  if (!zoom.searched) actions.push_back(call(action::find_zooms));
  ImGui::BeginDisabled(zoom.starting);
  if (ImGui::Button(zoom.running ? "Stop" : "Record"))
    actions.push_back(call(action::toggle_zoom_recording));
  ImGui::EndDisabled();
  command_tooltip("Record a zoom");
  ImGui::SameLine();
  ImGui::TextWrapped("%s", (zoom.running ? zoom_status(zoom) : zoom_plan_text(viewer)).c_str());
  draw_shown_zoom(zoom, actions);
  draw_plan(viewer, actions);
  draw_recordings(zoom, actions);
}

}  // namespace qs
