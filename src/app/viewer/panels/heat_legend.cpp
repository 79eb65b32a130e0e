// SPDX-License-Identifier: MIT
#include <algorithm>

#include <imgui.h>

#include "app/viewer/panels/color_bar.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

/// `under`: the value under the cursor.
void draw_legend(const Viewer& viewer, const std::string& title, const std::string& under,
                 const std::function<glm::vec3(float)>& color, const std::vector<BarTick>& ticks,
                 const std::string& facts) {
  const Rect picture = current_layout(viewer).picture;
  const float width = std::min(picture.size().x - 20, 46 * ImGui::GetFontSize());
  ImGui::SetNextWindowPos({picture.center().x, picture.high.y - 12}, ImGuiCond_Always, {0.5f, 1});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::Begin("Heat map", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoInputs |
                   ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoBringToFrontOnFocus);
  ImGui::TextUnformatted(title.c_str());
  const float shift = ImGui::CalcTextSize(under.c_str()).x;
  ImGui::SameLine(width - shift - ImGui::GetStyle().WindowPadding.x);
  ImGui::TextColored(palette::kAccent, "%s", under.c_str());
  draw_color_bar(color, ticks);
  ImGui::TextColored(palette::kFaint, "%s", facts.c_str());
  ImGui::End();
}

}  // namespace

void draw_heat_legend(const Viewer& viewer) {
  const ShownFrame& shown = viewer.shown;
  if (shown.heatmap) {
    const Heatmap& map = *shown.heatmap;
    const auto cell = cell_under_mouse(viewer, map.cell_px * shown.divisor, map.columns, map.rows);
    draw_legend(
        viewer, make_legend(map, shown.map_scale, mode_name(shown.mode)).title,
        cell ? heat_text(shown, *cell) : "",
        [](float t) { return t > 0 ? heat(t) : heat_of_zero(0.5f); }, heat_ticks(shown),
        heat_facts(shown));
  } else if (shown.values) {
    const ValueMap& map = *shown.values;
    const auto pixel = cell_under_mouse(viewer, shown.divisor, map.width, map.height);
    draw_legend(viewer, row_of(map.quantity).title, pixel ? value_text(shown, *pixel) : "", viridis,
                value_ticks(shown), value_facts(shown));
  }
}

}  // namespace qs
