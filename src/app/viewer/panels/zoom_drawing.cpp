// SPDX-License-Identifier: MIT
#include "app/viewer/panels/zoom_drawing.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/plot_axes.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

PlotAxes axes_of(const ZoomChart& chart) {
  PlotAxes axes{{}, {}, kZoomAxis};
  for (const AxisTick& tick : chart.zoom_ticks)
    axes.across.push_back({static_cast<float>(chart.place(tick.value, 0).x), tick.text});
  for (const AxisTick& tick : chart.value_ticks)
    axes.up.push_back({static_cast<float>(tick.value / chart.most_value), tick.text});
  return axes;
}

// Dashes of 6 units with gaps of 4, continued from segment to segment.
void draw_dashed(ImDrawList& draw, const std::vector<ImVec2>& points, ImU32 color) {
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
        draw.AddLine({a.x, a.y}, {b.x, b.y}, color, 1.5f * by);
      }
      at = std::max(end, at + 0.01f * by);
    }
    along += length;
  }
}

void draw_band(ImDrawList& draw, const ZoomChart& chart, const ZoomCurve& curve,
               const PlotArea& area) {
  const ImU32 color = ImGui::GetColorU32(zoom_color(curve.mode, 0.12f));
  const auto at = [&](const ZoomPoint& point, double value) {
    return area.at(chart.place(point.zoom, value));
  };
  for (std::size_t i = 1; i < curve.points.size(); ++i) {
    const ZoomPoint &a = curve.points[i - 1], &b = curve.points[i];
    const ImVec2 corners[] = {at(a, a.low), at(a, a.high), at(b, b.high), at(b, b.low)};
    draw.AddConvexPolyFilled(corners, 4, color);
  }
}

// quadbox-naive lists the same pairs as quadbox: its wider curve stays visible under the other.
void draw_curve(ImDrawList& draw, const ZoomChart& chart, const ZoomCurve& curve,
                const PlotArea& area) {
  std::vector<ImVec2> points;
  for (const ZoomPoint& point : curve.points)
    points.push_back(area.at(chart.place(point.zoom, point.value)));
  const ImU32 color = ImGui::GetColorU32(zoom_color(curve.mode, curve.is_beneath ? 0.7f : 1));
  if (curve.is_beneath) return draw_dashed(draw, points, color);
  const float by = drawing_scale(), width = curve.mode == find_culler("quadbox-naive") ? 3.5f : 2;
  draw.AddPolyline(points.data(), static_cast<int>(points.size()), color, 0, width * by);
  for (const ImVec2& point : points) draw.AddCircleFilled(point, 2.5f * by, color);
}

void draw_reading(const ZoomReading& reading) {
  const bool two = std::any_of(reading.rows.begin(), reading.rows.end(),
                               [](const ZoomReading::Row& row) { return !row.beneath.empty(); });
  ImGui::BeginTooltip();
  ImGui::TextColored(palette::kFaint, "%s%s", reading.title.c_str(),
                     two ? ", dashed at the right" : "");
  if (ImGui::BeginTable("values", two ? 3 : 2, ImGuiTableFlags_SizingFixedFit)) {
    for (const ZoomReading::Row& row : reading.rows) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextColored(zoom_color(row.mode), "%s", mode_name(row.mode));
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(row.value.c_str());
      if (two && ImGui::TableNextColumn()) ImGui::TextUnformatted(row.beneath.c_str());
    }
    ImGui::EndTable();
  }
  ImGui::EndTooltip();
}

}  // namespace

ImVec4 zoom_color(CullMode mode, float opacity) {
  return palette::with_opacity(on_dark::mode_color(mode), opacity);
}

void draw_zoom_chart(const ZoomChart& chart) {
  if (chart.empty()) return;
  const PlotArea area = draw_plot_axes("chart", axes_of(chart), 14 * ImGui::GetFontSize());
  const bool hovered = ImGui::IsItemHovered();
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  for (const ZoomCurve& curve : chart.curves) {
    if (curve.is_banded) draw_band(draw, chart, curve, area);
  }
  for (const ZoomCurve& curve : chart.curves) draw_curve(draw, chart, curve, area);
  if (!hovered) return;
  const auto reading = read_zoom_chart(chart, area.mouse_x());
  if (!reading) return;
  const float line = area.at(chart.place(reading->zoom, 0)).x;
  draw.AddLine({line, area.low.y}, {line, area.high.y}, IM_COL32(255, 255, 255, 120));
  draw_reading(*reading);
}

}  // namespace qs
