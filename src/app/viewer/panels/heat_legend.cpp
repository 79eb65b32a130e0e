// SPDX-License-Identifier: MIT
#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "app/picture/colormap.h"
#include "app/text.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/style.h"

namespace qs {
namespace {

void draw_bar(const Scale& scale, const Legend& legend) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float width = ImGui::GetContentRegionAvail().x, height = 0.9f * ImGui::GetFontSize();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  constexpr int kSteps = 64;
  for (int i = 0; i < kSteps; ++i) {
    const auto color = [](int step) {
      const glm::vec3 c = viridis(static_cast<float>(step) / kSteps);
      return ImGui::GetColorU32({c.x, c.y, c.z, 1});
    };
    const float left = at.x + width * static_cast<float>(i) / kSteps;
    const float right = at.x + width * static_cast<float>(i + 1) / kSteps;
    draw.AddRectFilledMultiColor({left, at.y}, {right, at.y + height}, color(i), color(i + 1),
                                 color(i + 1), color(i));
  }
  const std::vector<std::uint32_t> ticks = scale.ticks();
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const float x = at.x + width * static_cast<float>(ticks[i]) / static_cast<float>(scale.maximum);
    const float text = ImGui::CalcTextSize(legend.ticks[i].c_str()).x;
    const float left = i == 0 ? x : i + 1 == ticks.size() ? x - text : x - 0.5f * text;
    draw.AddLine({x, at.y + height}, {x, at.y + height + 4}, ImGui::GetColorU32(palette::kFaint));
    draw.AddText({left, at.y + height + 5}, ImGui::GetColorU32(palette::kText),
                 legend.ticks[i].c_str());
  }
  ImGui::Dummy({width, height + 6 + ImGui::GetTextLineHeight()});
}

}  // namespace

void draw_heat_legend(const Viewer& viewer, const PanelMemory& memory) {
  if (!viewer.shown.heatmap) return;
  const Heatmap& map = *viewer.shown.heatmap;
  const char* mode = kCullers[static_cast<std::size_t>(viewer.shown.mode)].name;
  const Legend legend = make_legend(map, memory.heat_scale, mode);
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float width = std::min(display.x - 40, 46 * ImGui::GetFontSize());
  ImGui::SetNextWindowPos({0.5f * display.x, display.y - 12}, ImGuiCond_Always, {0.5f, 1});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::Begin("Heat map", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoInputs |
                   ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoBringToFrontOnFocus);
  ImGui::TextUnformatted(legend.title.c_str());
  const HeatmapRow& row = kHeatmaps[static_cast<std::size_t>(map.quantity)];
  const int cell = map.cell_px * viewer.shown.divisor;
  const glm::ivec2 at = glm::ivec2(glm::floor(memory.cursor)) / std::max(cell, 1);
  const bool inside = memory.cursor.x >= 0 && memory.cursor.y >= 0 && at.x < map.columns &&
                      at.y < map.rows && mouse_is_free();
  const std::string under =
      inside ? fmt::format("under the cursor: {} {}",
                           grouped(map.values[static_cast<std::size_t>(at.y * map.columns + at.x)]),
                           row.unit)
             : "";
  const float shift = ImGui::CalcTextSize(under.c_str()).x;
  ImGui::SameLine(width - shift - ImGui::GetStyle().WindowPadding.x);
  ImGui::TextColored(palette::kAccent, "%s", under.c_str());
  draw_bar(memory.heat_scale, legend);
  ImGui::TextColored(palette::kFaint, "%s", legend.facts.c_str());
  ImGui::End();
}

}  // namespace qs
