// SPDX-License-Identifier: MIT
#include <algorithm>

#include <imgui.h>

#include "app/viewer/panels/color_bar.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {

void draw_heat_legend(const Viewer& viewer) {
  if (!viewer.shown.heatmap) return;
  const ShownFrame& shown = viewer.shown;
  const Heatmap& map = *shown.heatmap;
  const Rect picture = current_layout(viewer).picture;
  const float width = std::min(picture.size().x - 20, 46 * ImGui::GetFontSize());
  ImGui::SetNextWindowPos({picture.center().x, picture.high.y - 12}, ImGuiCond_Always, {0.5f, 1});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::Begin("Heat map", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoInputs |
                   ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoBringToFrontOnFocus);
  ImGui::TextUnformatted(make_legend(map, shown.map_scale, mode_name(shown.mode)).title.c_str());
  const auto cell = cell_under_mouse(viewer, map.cell_px * shown.divisor, map.columns, map.rows);
  const std::string under = cell ? heat_text(shown, *cell) : "";
  const float shift = ImGui::CalcTextSize(under.c_str()).x;
  ImGui::SameLine(width - shift - ImGui::GetStyle().WindowPadding.x);
  ImGui::TextColored(palette::kAccent, "%s", under.c_str());
  draw_color_bar([](float t) { return t > 0 ? heat(t) : heat_of_zero(0.5f); }, heat_ticks(shown));
  ImGui::TextColored(palette::kFaint, "%s", heat_facts(shown).c_str());
  ImGui::End();
}

}  // namespace qs
