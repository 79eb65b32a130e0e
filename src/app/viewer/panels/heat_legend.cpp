// SPDX-License-Identifier: MIT
#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "app/session/text.h"
#include "app/viewer/panels/color_bar.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

std::vector<Tick> ticks_of(const Scale& scale, const Legend& legend) {
  std::vector<Tick> ticks;
  for (const std::uint32_t value : scale.ticks())
    ticks.push_back({static_cast<float>(value) / static_cast<float>(scale.maximum),
                     legend.ticks[ticks.size()]});
  return ticks;
}

// The value under the mouse, empty where there is none.
std::string under_mouse(const ShownFrame& shown, const PanelMemory& memory) {
  const Heatmap& map = *shown.heatmap;
  const auto cell = cell_under_mouse(memory, map.cell_px * shown.divisor, map.columns, map.rows);
  if (!cell) return {};
  std::string text =
      fmt::format("here: {} {}", grouped(map.values[*cell]), heatmap_row(map.quantity).unit);
  if (shown.missed && map.values[*cell] > 0)
    text += fmt::format(", alpha to {:.2f}, color off by {:.3f}", shown.missed->alphas[*cell],
                        shown.missed->errors[*cell]);
  return text;
}

}  // namespace

void draw_heat_legend(const Viewer& viewer, const PanelMemory& memory) {
  if (!viewer.shown.heatmap) return;
  const Heatmap& map = *viewer.shown.heatmap;
  const char* mode = mode_name(viewer.shown.mode);
  const Legend legend = make_legend(map, memory.heat_scale, mode);
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float width = std::min(display.x - 40, 46 * ImGui::GetFontSize());
  ImGui::SetNextWindowPos({0.5f * display.x, display.y - 12}, ImGuiCond_Always, {0.5f, 1});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::Begin("Heat map", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoInputs |
                   ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoBringToFrontOnFocus);
  ImGui::TextUnformatted(legend.title.c_str());
  const std::string under = under_mouse(viewer.shown, memory);
  const float shift = ImGui::CalcTextSize(under.c_str()).x;
  ImGui::SameLine(width - shift - ImGui::GetStyle().WindowPadding.x);
  ImGui::TextColored(palette::kAccent, "%s", under.c_str());
  draw_color_bar(viridis, ticks_of(memory.heat_scale, legend));
  const std::string facts = viewer.shown.missed ? fmt::format("mode {} \u00b7 {}", mode,
                                                              missed_sentence(*viewer.shown.missed))
                                                : legend.facts;
  ImGui::TextColored(palette::kFaint, "%s", facts.c_str());
  ImGui::End();
}

}  // namespace qs
