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

#include "app/viewer/panels/controls_drawer.h"
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

// ---- the plan ----------------------------------------------------------------------------------
void draw_ends(const ZoomPlan& plan, const ControlsDrawer& controls) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(zoom_start_text(plan));
  controls.draw_button_after("start here");
  controls.draw_button_after("this view");
  ImGui::SetNextItemWidth(5 * ImGui::GetFontSize());
  controls.draw("x closer");
  controls.draw_button_after("end here");
}

void draw_mode_choice(const ControlsDrawer& controls) {
  const float box = ImGui::GetFrameHeight() + ImGui::GetStyle().ItemInnerSpacing.x;
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const char* const name = mode_name(mode);
    if (mode > 1) same_line_if_fits(box + ImGui::CalcTextSize(name).x);
    ImGui::PushStyleColor(ImGuiCol_Text, zoom_color(mode));
    controls.draw(fmt::format("record {}", name), name);
    ImGui::PopStyleColor();
  }
}

void draw_plan(const Viewer& viewer, const ControlsDrawer& controls) {
  const float letter = ImGui::GetFontSize();
  draw_ends(viewer.zoom.plan, controls);
  ImGui::PushItemWidth(7 * letter);
  for (const char* name : {"steps", "frames per mode and step"}) controls.draw(name);
  ImGui::PopItemWidth();
  ImGui::PushItemWidth(14 * letter);
  for (const char* name : {"size", "pipeline of the zoom"}) controls.draw(name);
  ImGui::PopItemWidth();
  draw_mode_choice(controls);
}

// ---- the chart ---------------------------------------------------------------------------------
void draw_zoom_legend(const ZoomChart& chart) {
  bool is_first = true;
  for (const ZoomCurve& curve : chart.curves) {
    if (curve.is_beneath) continue;
    if (!std::exchange(is_first, false))
      same_line_if_fits(ImGui::CalcTextSize(mode_name(curve.mode)).x);
    ImGui::TextColored(zoom_color(curve.mode), "%s", mode_name(curve.mode));
  }
}

void draw_shown_zoom(const ZoomRecorder& zoom, const ControlsDrawer& controls, Actions& actions) {
  const ZoomRecord* record = shown_zoom(zoom);
  if (record == nullptr) return;
  const ZoomRecord* beneath = zoom_beneath(zoom);
  const ZoomChart chart = zoom_chart(record, beneath, zoom.quantity);
  if (!chart.empty()) {
    controls.draw_radio_buttons("chart of");
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
  same_line_if_fits(6 * ImGui::GetFontSize());
  if (ImGui::SmallButton("Copy figure")) actions.push_back(call(action::copy_zoom_figure));
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("copies the path of the plot of this quantity, a PNG file");
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
  const ControlsDrawer controls(viewer, actions);
  controls.draw("Record");
  ImGui::SameLine();
  ImGui::TextWrapped("%s", (zoom.running ? zoom_status(zoom) : zoom_plan_text(viewer)).c_str());
  draw_shown_zoom(zoom, controls, actions);
  draw_plan(viewer, controls);
  draw_recordings(zoom, actions);
}

}  // namespace qs
