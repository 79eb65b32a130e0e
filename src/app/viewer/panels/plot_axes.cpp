// SPDX-License-Identifier: MIT
#include "app/viewer/panels/plot_axes.h"

#include <algorithm>

#include "app/viewer/panels/style.h"

namespace qs {
namespace {

constexpr ImU32 kGridLine = IM_COL32(255, 255, 255, 28);

float text_width(const std::string& text) { return ImGui::CalcTextSize(text.c_str()).x; }

PlotArea plot_area(const PlotAxes& axes, ImVec2 at, ImVec2 size) {
  const float letter = ImGui::GetFontSize();
  float widest = 0;
  for (const BarTick& tick : axes.up) widest = std::max(widest, text_width(tick.text));
  return {{at.x + widest + 0.5f * letter, at.y + 0.6f * letter},
          {at.x + size.x - 0.8f * letter, at.y + size.y - 2.5f * letter}};
}

void draw_ticks_up(ImDrawList& draw, const PlotAxes& axes, const PlotArea& area) {
  const float letter = ImGui::GetFontSize();
  float free_below = 1e9f;
  for (const BarTick& tick : axes.up) {
    const float y = area.at({0, tick.at}).y;
    draw.AddLine({area.low.x, y}, {area.high.x, y}, kGridLine);
    if (y + 0.5f * letter > free_below) continue;
    draw.AddText({area.low.x - text_width(tick.text) - 0.4f * letter, y - 0.5f * letter},
                 ImGui::GetColorU32(palette::kFaint), tick.text.c_str());
    free_below = y - 0.5f * letter;
  }
}

// A text at the right end is moved to the left until it is inside of the panel.
void draw_ticks_across(ImDrawList& draw, const PlotAxes& axes, const PlotArea& area, float right) {
  const float letter = ImGui::GetFontSize();
  float free_from = -1e9f;
  for (const BarTick& tick : axes.across) {
    const float x = area.at({tick.at, 0}).x;
    draw.AddLine({x, area.low.y}, {x, area.high.y}, kGridLine);
    const float width = text_width(tick.text);
    const float left = std::min(x - 0.5f * width, right - width);
    if (left < free_from) continue;
    draw.AddText({left, area.high.y + 0.2f * letter}, ImGui::GetColorU32(palette::kFaint),
                 tick.text.c_str());
    free_from = left + width + 0.4f * letter;
  }
}

}  // namespace

PlotArea draw_plot_axes(const char* name, const PlotAxes& axes, float height) {
  const float letter = ImGui::GetFontSize();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImVec2 size{std::max(ImGui::GetContentRegionAvail().x, 10 * letter), height};
  const PlotArea area = plot_area(axes, at, size);
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw_ticks_up(draw, axes, area);
  draw_ticks_across(draw, axes, area, at.x + size.x);
  const float middle = 0.5f * (area.low.x + area.high.x) - 0.5f * text_width(axes.title);
  draw.AddText({middle, area.high.y + 1.3f * letter}, ImGui::GetColorU32(palette::kFaint),
               axes.title.c_str());
  ImGui::InvisibleButton(name, size);
  return area;
}

}  // namespace qs
