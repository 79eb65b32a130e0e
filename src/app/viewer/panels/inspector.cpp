// SPDX-License-Identifier: MIT
//
// The inspector: the Gaussians of the clicked pixel, front to back, and the tiles of every mode for
// one of them.
#include <algorithm>
#include <span>
#include <utility>

#include <imgui.h>

#include "app/viewer/panels/construction.h"
#include "app/viewer/panels/controls_drawer.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

void cell(const std::string& text) {
  ImGui::TableNextColumn();
  right_aligned(text);
}

void draw_row(const Contribution& row, bool picked, bool stops, const ControlsDrawer& controls) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  const std::string label = contribution_label(row, stops);
  if (ImGui::Selectable(label.c_str(), picked, ImGuiSelectableFlags_SpanAllColumns))
    controls.set("Gaussian", 0, row.gaussian);
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

void draw_contributions(const Inspection& inspection, float height, bool scroll,
                        const ControlsDrawer& controls) {
  constexpr ImGuiTableFlags kFlags =
      ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp;
  const PixelReport& pixel = inspection.pixel;
  if (!ImGui::BeginTable("contributions", 6, kFlags, {0, height})) return;
  for (const float share : {1.4f, 1.0f, 1.0f, 1.0f, 1.0f, 0.8f})
    ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch, share);
  ImGui::TableSetupScrollFreeze(0, 1);
  ImGui::TableNextRow(ImGuiTableRowFlags_Headers);
  const std::span names(kContributionColumns);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(names.front());
  for (const char* name : names.subspan(1, names.size() - 2)) cell(name);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(names.back());
  const auto draw = [&](const Contribution& row, bool stops) {
    const bool picked = inspection.gaussian && inspection.gaussian->gaussian == row.gaussian;
    draw_row(row, picked, stops, controls);
    if (picked && scroll) ImGui::SetScrollHereY();
  };
  for (const Contribution& row : pixel.contributions) draw(row, false);
  if (pixel.stopped_by) draw(*pixel.stopped_by, true);
  ImGui::EndTable();
}

}  // namespace

void draw_inspector(const Viewer& viewer, PanelState& state, Actions& actions) {
  if (!viewer.inspected) {
    ImGui::TextWrapped("%s", kNothingInspected);
    return;
  }
  const Inspection& inspection = viewer.inspected->inspection;
  ImGui::TextWrapped("%s", inspected_pixel_text(inspection.pixel).c_str());
  if (viewer.inspected->version != viewer.version)
    ImGui::TextColored(palette::kCaution, "%s", kInspectedEarlier);
  draw_transmittance(inspection.pixel);
  const bool scroll = std::exchange(state.inspections, viewer.inspections) != viewer.inspections;
  const std::size_t rows = inspection.pixel.contributions.size() + 2;
  const float lines = static_cast<float>(std::min<std::size_t>(rows, 12));
  const float line = ImGui::GetTextLineHeight() + 2 * ImGui::GetStyle().CellPadding.y;
  draw_contributions(inspection, lines * line, scroll, ControlsDrawer(viewer, actions));
  if (inspection.gaussian) draw_construction_view(*viewer.inspected, viewer.mode());
}

}  // namespace qs
