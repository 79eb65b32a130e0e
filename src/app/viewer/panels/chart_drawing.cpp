// SPDX-License-Identifier: MIT
//
// Charts: axes with lines at the ticks, columns, bars and curves, and the values at the mouse. And
// the bar of a legend with its ticks below it, which fills the width of the panel.
#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

ImU32 chart_line() { return ImGui::GetColorU32(ImGuiCol_Text, 0.11f); }

// The area of the curves in the window, screen units.
struct PlotArea {
  ImVec2 low, high;

  ImVec2 at(double x, double y) const {
    return {low.x + static_cast<float>(x) * (high.x - low.x),
            high.y - static_cast<float>(y) * (high.y - low.y)};
  }
  double mouse_x() const {
    return static_cast<double>((ImGui::GetIO().MousePos.x - low.x) / (high.x - low.x));
  }
};

float text_width(const std::string& text) { return ImGui::CalcTextSize(text.c_str()).x; }

void draw_faint(ImVec2 at, const std::string& text) {
  ImGui::GetWindowDrawList()->AddText(at, ImGui::GetColorU32(palette::kFaint), text.c_str());
}

PlotArea plot_area(const block::Chart& chart, ImVec2 at, ImVec2 size) {
  const float letter = ImGui::GetFontSize();
  float widest = 0;
  for (const BarTick& tick : chart.up) widest = std::max(widest, text_width(tick.text));
  return {{at.x + widest + 0.5f * letter, at.y + 0.6f * letter},
          {at.x + size.x - 0.8f * letter,
           at.y + size.y - (chart.across.empty() ? 1.6f : 2.5f) * letter}};
}

void draw_ticks_up(const block::Chart& chart, const PlotArea& area) {
  const float letter = ImGui::GetFontSize();
  float free_below = 1e9f;
  for (const BarTick& tick : chart.up) {
    const float y = area.at(0, static_cast<double>(tick.at)).y;
    ImGui::GetWindowDrawList()->AddLine({area.low.x, y}, {area.high.x, y}, chart_line());
    if (y + 0.5f * letter > free_below) continue;
    draw_faint({area.low.x - text_width(tick.text) - 0.4f * letter, y - 0.5f * letter}, tick.text);
    free_below = y - 0.5f * letter;
  }
}

// A text at the right end is moved to the left until it is inside of the panel.
void draw_ticks_across(const block::Chart& chart, const PlotArea& area, float right) {
  const float letter = ImGui::GetFontSize();
  float free_from = -1e9f;
  for (const BarTick& tick : chart.across) {
    const float x = area.at(static_cast<double>(tick.at), 0).x;
    ImGui::GetWindowDrawList()->AddLine({x, area.low.y}, {x, area.high.y}, chart_line());
    const float width = text_width(tick.text);
    const float left = std::min(x - 0.5f * width, right - width);
    if (left < free_from) continue;
    draw_faint({left, area.high.y + 0.2f * letter}, tick.text);
    free_from = left + width + 0.4f * letter;
  }
}

// Texts that would touch the previous one are left out. The item is hovered while the mouse is on
// the chart.
PlotArea draw_axes(const block::Chart& chart) {
  const float letter = ImGui::GetFontSize();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImVec2 size{std::max(ImGui::GetContentRegionAvail().x, 10 * letter),
                    chart.letters * letter};
  const PlotArea area = plot_area(chart, at, size);
  draw_ticks_up(chart, area);
  draw_ticks_across(chart, area, at.x + size.x);
  const float middle = 0.5f * (area.low.x + area.high.x) - 0.5f * text_width(chart.axis);
  draw_faint({middle, area.high.y + (chart.across.empty() ? 0.3f : 1.3f) * letter}, chart.axis);
  ImGui::InvisibleButton("chart", size);
  return area;
}

// Dashes of 6 units with gaps of 4, continued from segment to segment.
void draw_dashed(ImDrawList& draw, const std::vector<ImVec2>& points, ImU32 color, float width) {
  const float by = drawing_scale(), dash = 6 * by, period = 10 * by;
  float along = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const glm::vec2 from{points[i - 1].x, points[i - 1].y}, to{points[i].x, points[i].y};
    const float length = glm::distance(from, to);
    for (float at = 0; at < length;) {
      const float phase = std::fmod(along + at, period);
      const float end = std::min(length, at + (phase < dash ? dash : period) - phase);
      if (phase < dash) {
        const glm::vec2 a = glm::mix(from, to, at / length), b = glm::mix(from, to, end / length);
        draw.AddLine({a.x, a.y}, {b.x, b.y}, color, width);
      }
      at = std::max(end, at + 0.01f * by);
    }
    along += length;
  }
}

// The bars of the curves of a point stand side by side.
void draw_bars(ImDrawList& draw, const block::Chart& chart, const PlotArea& area) {
  const float step = 2 * drawing_scale();
  float aside = -0.5f * step * static_cast<float>(chart.curves.size() - 1);
  for (const block::Curve& curve : chart.curves) {
    for (const block::ChartPoint& point : curve.points) {
      if (!curve.has_bars) break;
      const ImVec2 low = area.at(point.x, point.low), high = area.at(point.x, point.high);
      draw.AddLine({low.x + aside, low.y}, {high.x + aside, high.y}, color_of(curve.ink, 0.8f),
                   drawing_scale());
    }
    aside += step;
  }
}

void draw_curve(ImDrawList& draw, const block::Curve& curve, const PlotArea& area) {
  std::vector<ImVec2> points;
  for (const block::ChartPoint& point : curve.points) points.push_back(area.at(point.x, point.y));
  const float by = drawing_scale();
  const ImU32 color = color_of(curve.ink, curve.is_dashed ? 0.7f : 1);
  if (curve.is_dashed) return draw_dashed(draw, points, color, curve.width * by);
  draw.AddPolyline(points.data(), static_cast<int>(points.size()), color, 0, curve.width * by);
  if (!curve.is_marked) return;
  for (std::size_t i = 0; i < points.size(); ++i) {
    draw.AddCircleFilled(points[i], 2.5f * by, color);
    if (curve.points[i].is_noisy) draw.AddCircle(points[i], 5 * by, color, 0, 1.2f * by);
  }
}

void draw_reading(const block::Reading& reading) {
  const bool two =
      std::ranges::any_of(reading.rows, [](const auto& row) { return !row.beneath.empty(); });
  ImGui::BeginTooltip();
  ImGui::TextColored(palette::kFaint, "%s%s", reading.title.c_str(),
                     two ? ", dashed at the right" : "");
  if (!reading.rows.empty() &&
      ImGui::BeginTable("values", two ? 3 : 2, ImGuiTableFlags_SizingFixedFit)) {
    for (const block::Reading::Row& row : reading.rows) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextColored(palette::text_of(row.ink), "%s", row.name.c_str());
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(row.value.c_str());
      if (two && ImGui::TableNextColumn()) ImGui::TextUnformatted(row.beneath.c_str());
    }
    ImGui::EndTable();
  }
  ImGui::EndTooltip();
}

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

void draw_chart(const block::Chart& chart) {
  if (!chart.title.empty()) ImGui::TextColored(palette::kFaint, "%s", chart.title.c_str());
  const PlotArea area = draw_axes(chart);
  const bool hovered = ImGui::IsItemHovered();
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  for (const block::ChartColumn& column : chart.columns) {
    const ImVec2 low = area.at(column.x0, column.y), high = area.at(column.x1, 0);
    draw.AddRectFilled(low, {std::max(high.x, low.x + 1), high.y}, color_of(column.color, 0.7f));
  }
  draw_bars(draw, chart, area);
  for (const block::Curve& curve : chart.curves) draw_curve(draw, curve, area);
  if (!hovered || !chart.reading) return;
  const auto reading = chart.reading(area.mouse_x());
  if (!reading) return;
  const float line = area.at(reading->x, 0).x;
  draw.AddLine({line, area.low.y}, {line, area.high.y}, ImGui::GetColorU32(ImGuiCol_Text, 0.5f));
  draw_reading(*reading);
}

float color_bar_height() {
  return std::round(0.9f * ImGui::GetFontSize()) + 6 + ImGui::GetTextLineHeight();
}

void draw_color_bar(const Legend& legend) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float letter = ImGui::GetFontSize(), height = std::round(0.9f * letter);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const int width = std::max(1, static_cast<int>(ImGui::GetContentRegionAvail().x));
  draw_bar_columns(draw, at, bar_colors(legend, width, static_cast<int>(height)), height);
  // The value 0 has nearly the colour of the panel.
  draw.AddRect(at, {at.x + static_cast<float>(width), at.y + height},
               ImGui::GetColorU32(ImGuiCol_TextDisabled, 0.5f));
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
  ImGui::Dummy({static_cast<float>(width), color_bar_height()});
}

}  // namespace qs
