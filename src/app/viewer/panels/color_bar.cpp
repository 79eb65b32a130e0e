// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <imgui.h>

#include "app/viewer/panels/blocks.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

// Columns of equal colours are one rectangle.
void draw_bar_columns(ImDrawList& draw, ImVec2 at, const std::vector<glm::vec3>& colors,
                      float height) {
  for (std::size_t first = 0; first < colors.size();) {
    std::size_t end = first + 1;
    while (end < colors.size() && colors[end] == colors[first]) ++end;
    draw.AddRectFilled({at.x + static_cast<float>(first), at.y},
                       {at.x + static_cast<float>(end), at.y + height}, color_of(colors[first]));
    first = end;
  }
}

}  // namespace

void draw_color_bar(const Legend& legend) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float letter = ImGui::GetFontSize(), height = std::round(0.9f * letter);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const int width = std::max(1, static_cast<int>(ImGui::GetContentRegionAvail().x));
  draw_bar_columns(draw, at, bar_colors(legend, width, static_cast<int>(height)), height);
  // The value 0 has nearly the colour of the panel.
  draw.AddRect(at, {at.x + static_cast<float>(width), at.y + height},
               ImGui::GetColorU32(palette::with_opacity(on_dark::kFaint, 0.5f)));
  const auto text_width = [](const std::string& text) {
    return static_cast<int>(std::ceil(ImGui::CalcTextSize(text.c_str()).x));
  };
  const auto placed = place_ticks(legend.ticks, width, static_cast<int>(0.5f * letter), text_width);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const std::string& text = legend.ticks[i].text;
    const float x = at.x + static_cast<float>(placed[i].line);
    draw.AddLine({x, at.y + height}, {x, at.y + height + 4}, ImGui::GetColorU32(palette::kFaint));
    if (!placed[i].has_text) continue;
    const float share = 0.5f * static_cast<float>(placed[i].align);  // of the width, left of it
    const float left = at.x + static_cast<float>(placed[i].text) -
                       std::floor(share * static_cast<float>(text_width(text)));
    draw.AddText({left, at.y + height + 5}, ImGui::GetColorU32(palette::kText), text.c_str());
  }
  ImGui::Dummy({static_cast<float>(width), height + 6 + ImGui::GetTextLineHeight()});
}

}  // namespace qs
