// SPDX-License-Identifier: MIT
//
// The inspector: the Gaussians of the clicked pixel, front to back, and how every mode covers one
// of them.
#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

void cell(const std::string& text) {
  ImGui::TableNextColumn();
  right_aligned(text);
}

void draw_row(const Contribution& row, bool picked, bool stops, Actions& actions) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  const std::string label = fmt::format("{}{}", row.gaussian, stops ? " stops" : "");
  if (ImGui::Selectable(label.c_str(), picked, ImGuiSelectableFlags_SpanAllColumns))
    actions.push_back(call(action::inspect_gaussian, row.gaussian));
  for (const std::string& text : contribution_cells(row, stops)) cell(text);
  ImGui::TableNextColumn();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float height = ImGui::GetTextLineHeight();
  const auto shown = [](float value) { return std::clamp(value, 0.0f, 1.0f); };
  ImGui::GetWindowDrawList()->AddRectFilled(
      at, {at.x + 2 * height, at.y + height},
      ImGui::GetColorU32({shown(row.color.r), shown(row.color.g), shown(row.color.b), 1}), 3);
  ImGui::Dummy({2 * height, height});
}

void draw_contributions(const Inspection& inspection, float height, bool scroll, Actions& actions) {
  constexpr ImGuiTableFlags kFlags =
      ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp;
  const PixelReport& pixel = inspection.pixel;
  if (!ImGui::BeginTable("contributions", 6, kFlags, {0, height})) return;
  ImGui::TableSetupScrollFreeze(0, 1);
  ImGui::TableNextRow(ImGuiTableRowFlags_Headers);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted("Gaussian");
  for (const char* name : {"depth", "alpha", "in front", "weight"}) cell(name);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted("color");
  const auto draw = [&](const Contribution& row, bool stops) {
    const bool picked = inspection.gaussian && inspection.gaussian->gaussian == row.gaussian;
    draw_row(row, picked, stops, actions);
    if (picked && scroll) ImGui::SetScrollHereY();
  };
  for (const Contribution& row : pixel.contributions) draw(row, false);
  if (pixel.stopped_by) draw(*pixel.stopped_by, true);
  ImGui::EndTable();
}

}  // namespace

void draw_inspector(const Viewer& viewer, PanelState& state, Actions& actions, float top) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float line = ImGui::GetTextLineHeightWithSpacing();
  ImGui::SetNextWindowPos({display.x - 10, top + 10}, ImGuiCond_FirstUseEver, {1, 0});
  ImGui::SetNextWindowSize(
      {std::min(52 * ImGui::GetFontSize(), 0.62f * display.x), display.y - top - 20},
      ImGuiCond_FirstUseEver);
  bool open = true;
  ImGui::Begin("Inspector", &open, ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing);
  if (!viewer.inspected) {
    ImGui::TextWrapped("Click a pixel of the picture.");
  } else {
    const Inspection& inspection = viewer.inspected->inspection;
    ImGui::TextUnformatted(inspected_pixel_text(inspection.pixel).c_str());
    if (viewer.inspected->version != viewer.version) {
      ImGui::SameLine();
      ImGui::TextColored(palette::kCaution, "(of an earlier view: click again)");
    }
    const bool scroll = std::exchange(state.inspections, viewer.inspections) != viewer.inspections;
    const ImVec2 room = ImGui::GetContentRegionAvail();
    if (state.construction != 0 && inspection.gaussian) {
      // The drawing leaves the list at least eight lines.
      const Image& picture = *viewer.inspected->construction;
      const float aspect = static_cast<float>(picture.width) / static_cast<float>(picture.height);
      const float height = std::min(room.x / aspect, std::max(room.y - 8 * line, 6 * line));
      draw_contributions(inspection, room.y - height - ImGui::GetStyle().ItemSpacing.y, scroll,
                         actions);
      ImGui::Image(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(state.construction)),
                   {height * aspect, height});
    } else {
      draw_contributions(inspection, room.y, scroll, actions);
    }
  }
  ImGui::End();
  if (!open) actions.push_back(call(action::toggle_panel, &Panels::inspector));
}

}  // namespace qs
