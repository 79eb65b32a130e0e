// SPDX-License-Identifier: MIT
//
// The inspector: the Gaussians of the pixel that was clicked, front to back, and how every mode
// covers one of them.
#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/style.h"

namespace qs {
namespace {

void cell(const std::string& text) {
  ImGui::TableNextColumn();
  const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(text.c_str()).x;
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(0.0f, room));
  ImGui::TextUnformatted(text.c_str());
}

void draw_row(const Contribution& row, bool picked, bool stops, Actions& actions) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  const std::string label = fmt::format("{}{}", row.gaussian, stops ? " stops" : "");
  if (ImGui::Selectable(label.c_str(), picked, ImGuiSelectableFlags_SpanAllColumns))
    actions.push_back(action::InspectGaussian{row.gaussian});
  cell(fmt::format("{:.3f}", row.depth));
  cell(fmt::format("{:.4f}", row.alpha));
  cell(fmt::format("{:.4f}", row.transmittance));
  cell(stops ? "-" : fmt::format("{:.4f}", row.weight));
  ImGui::TableNextColumn();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float height = ImGui::GetTextLineHeight();
  const auto shown = [](float value) { return std::clamp(value, 0.0f, 1.0f); };
  ImGui::GetWindowDrawList()->AddRectFilled(
      at, {at.x + 2 * height, at.y + height},
      ImGui::GetColorU32({shown(row.color.r), shown(row.color.g), shown(row.color.b), 1}), 3);
  ImGui::Dummy({2 * height, height});
}

void draw_contributions(const Inspection& inspection, Actions& actions) {
  constexpr ImGuiTableFlags kFlags =
      ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp;
  const PixelReport& pixel = inspection.pixel;
  if (!ImGui::BeginTable("contributions", 6, kFlags,
                         {0, 9 * ImGui::GetTextLineHeightWithSpacing()}))
    return;
  ImGui::TableSetupScrollFreeze(0, 1);
  for (const char* name : {"Gaussian", "depth", "alpha", "in front", "weight", "color"})
    ImGui::TableSetupColumn(name);
  ImGui::TableHeadersRow();
  const auto picked = [&](const Contribution& row) {
    return inspection.gaussian && inspection.gaussian->gaussian == row.gaussian;
  };
  for (const Contribution& row : pixel.contributions) draw_row(row, picked(row), false, actions);
  if (pixel.stopped_by) draw_row(*pixel.stopped_by, picked(*pixel.stopped_by), true, actions);
  ImGui::EndTable();
}

}  // namespace

void draw_inspector(const Viewer& viewer, const PanelMemory& memory, Actions& actions, float top) {
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
    const PixelReport& pixel = inspection.pixel;
    ImGui::Text("Pixel %d, %d: %zu of the %u Gaussians of its tile are blended", pixel.pixel.x,
                pixel.pixel.y, pixel.contributions.size(), pixel.listed);
    if (viewer.inspected->version != viewer.version) {
      ImGui::SameLine();
      ImGui::TextColored(palette::kCaution, "(of an earlier view: click again)");
    }
    draw_contributions(inspection, actions);
    if (memory.construction != 0 && inspection.gaussian) {
      const Image& picture = viewer.inspected->construction;
      const ImVec2 room = ImGui::GetContentRegionAvail();
      const float aspect = static_cast<float>(picture.width) / static_cast<float>(picture.height);
      const float width = std::min(room.x, std::max(room.y, 6 * line) * aspect);
      ImGui::Image(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(memory.construction)),
                   {width, width / aspect});
    }
  }
  ImGui::End();
  if (!open) actions.push_back(action::TogglePanel{&Panels::inspector});
}

}  // namespace qs
