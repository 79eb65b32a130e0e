// SPDX-License-Identifier: MIT
#include "app/viewer/commands/zoom_figure.h"

#include <fmt/format.h>

#include "app/measure/statistics.h"
#include "app/viewer/state/charts.h"
#include "io/bytes/replace_file.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

constexpr glm::ivec2 kZoomFigure{1400, 800};
constexpr int kChartLeft = 120, kChartTop = 130, kChartRight = 1170, kChartBottom = 680;
constexpr int kZoomTitle = 30, kZoomText = 24;

// The lines and texts of a figure with the pixels of the chart.
struct ZoomDrawing {
  const ZoomChart& chart;
  Figure figure = {};

  glm::vec2 at(double zoom, double value) const {
    const glm::dvec2 share = chart.place(zoom, value);
    return {kChartLeft + share.x * (kChartRight - kChartLeft),
            kChartBottom - share.y * (kChartBottom - kChartTop)};
  }
  void draw(std::vector<glm::vec2> points, glm::vec3 color, float width) {
    figure.lines.push_back({std::move(points), {color, width}});
  }
  void write(glm::ivec2 place, const std::string& text, Align align = Align::left,
             glm::vec3 color = on_white::kInk, int size = kZoomText) {
    figure.texts.push_back({place, size, text, color, align});
  }
};

// The bars of a step stand side by side, `aside` of the point, so that no mode hides another. The
// points of noisy steps are hollow.
void draw_zoom_curve(ZoomDrawing& drawing, const ZoomCurve& curve, glm::vec2 aside) {
  const glm::vec3 color = mode_color(curve.mode);
  std::vector<glm::vec2> points;
  for (const ZoomPoint& point : curve.points) {
    points.push_back(drawing.at(point.zoom, point.value));
    if (curve.has_bars)
      drawing.draw(
          {drawing.at(point.zoom, point.low) + aside, drawing.at(point.zoom, point.high) + aside},
          color, 2);
  }
  // quadbox-naive lists the same pairs as quadbox: its wider curve stays visible under the other.
  drawing.draw(points, color, curve.mode == find_culler("quadbox-naive") ? 6 : 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    drawing.draw({points[i], points[i]}, color, 12);
    if (curve.points[i].is_noisy) drawing.draw({points[i], points[i]}, on_white::kWhite, 7);
  }
}

}  // namespace

Figure zoom_figure(const ZoomBundle& bundle, ZoomQuantity quantity) {
  const ZoomRecord record = make_zoom_record(bundle);
  const ZoomChart chart = zoom_chart(&record, nullptr, quantity);
  const bool has_times = quantity != ZoomQuantity::pairs;
  ZoomDrawing drawing{chart};
  drawing.figure.size = kZoomFigure;
  drawing.write({kChartLeft, 14}, chart.title + " while zooming in", Align::left, on_white::kInk,
                kZoomTitle);
  drawing.write({kChartLeft, 52}, zoom_caption(bundle, has_times));
  drawing.write({kChartLeft, 82}, alterations_in(bundle.rows));
  drawing.write({(kChartLeft + kChartRight) / 2, kChartBottom + 44}, kZoomAxis, Align::center);
  const std::string noisy = noisy_steps(bundle.rows);
  if (has_times)
    drawing.write({kChartLeft, kChartBottom + 80},
                  fmt::format("bars: the middle half of the frames{}",
                              noisy.empty() ? "" : "; hollow: noisy steps, " + noisy),
                  Align::left, on_white::kFaint);
  for (const AxisTick& tick : chart.value_ticks) {
    const glm::ivec2 left = drawing.at(1, tick.value);
    drawing.draw({left, {kChartRight, left.y}}, on_white::kLine, 1);
    drawing.write({left.x - 16, left.y - kZoomText / 2}, tick.text, Align::right);
  }
  for (const AxisTick& tick : chart.zoom_ticks) {
    const glm::ivec2 below = drawing.at(tick.value, 0);
    drawing.draw({below, {below.x, kChartTop}}, on_white::kLine, 1);
    drawing.write({below.x, below.y + 14}, tick.text, Align::center);
  }
  const auto count = static_cast<int>(chart.curves.size());
  for (int i = 0; i < count; ++i) {
    const ZoomCurve& curve = chart.curves[static_cast<std::size_t>(i)];
    draw_zoom_curve(drawing, curve, {4 * i - 2 * (count - 1), 0});
    drawing.write({kChartRight + 24, kChartTop + i * (kZoomText + 8)}, mode_name(curve.mode),
                  Align::left, on_white::mode_color(curve.mode));
  }
  return drawing.figure;
}

void write_zoom_figures(const ZoomBundle& bundle, const std::filesystem::path& folder) {
  for (std::size_t i = 0; i < std::size(kZoomQuantities); ++i) {
    const Figure figure = zoom_figure(bundle, static_cast<ZoomQuantity>(i));
    std::filesystem::path path = folder / kZoomQuantities[i].figure;
    write_image(draw_figure(figure), path, {});
    write_text(path.replace_extension(".svg"), figure_svg(figure, figure.texts.front().text));
  }
}

}  // namespace qs
