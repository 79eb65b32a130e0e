// SPDX-License-Identifier: MIT
#include "app/viewer/state/charts.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/measure/statistics.h"
#include "base/text.h"

namespace qs {
namespace {

constexpr double kLeastZoomRange = 1.001;

double rate(double ms) { return ms > 0 ? 1000 / ms : 0; }

ZoomPoint point_of(const BenchRow& row, const ZoomRecord& record, ZoomQuantity quantity) {
  const double zoom = zoom_factor(row, record.steps, record.closest);
  const auto pairs = static_cast<double>(row.pairs);
  const auto [low, high] = middle_half(row);
  const bool noisy = is_noisy_step(row);
  if (quantity == ZoomQuantity::fps)
    return {zoom, rate(row.ms_median), rate(high), rate(low), noisy};
  if (quantity == ZoomQuantity::ms) return {zoom, row.ms_median, low, high, noisy};
  return {zoom, pairs, pairs, pairs};
}

void add_curves(const ZoomRecord& record, ZoomQuantity quantity, bool is_beneath,
                std::vector<ZoomCurve>& curves) {
  const bool barred = !is_beneath && quantity != ZoomQuantity::pairs && has_bars(record.rows);
  for (const CullMode mode : record.modes) {
    ZoomCurve curve{mode, is_beneath, barred, {}};
    for (const BenchRow& row : record.rows) {
      if (row.mode != mode_name(mode) || !(row.ms_median > 0)) continue;
      const ZoomPoint point = point_of(row, record, quantity);
      if (std::isfinite(point.zoom) && point.zoom > 0) curve.points.push_back(point);
    }
    if (!curve.points.empty()) curves.push_back(std::move(curve));
  }
}

// The factor between the unit of the vertical axis and a single pair.
double unit_of(double most, ZoomQuantity quantity) {
  if (quantity != ZoomQuantity::pairs) return 1;
  return most >= 1e6 ? 1e6 : most >= 1e4 ? 1e3 : 1;
}

void set_axes(ZoomChart& chart, ZoomQuantity quantity) {
  double most = 0;
  for (const ZoomCurve& curve : chart.curves)
    for (const ZoomPoint& point : curve.points)
      most = std::max(most, curve.has_bars ? std::max(point.high, point.value) : point.value);
  if (!(most > 0)) most = 1;
  const double unit = unit_of(most, quantity);
  chart.title = kZoomQuantities[static_cast<std::size_t>(quantity)].title;
  if (unit > 1) chart.title += unit > 1e3 ? " (millions)" : " (thousands)";
  chart.value_ticks = round_ticks(most / unit);
  for (AxisTick& tick : chart.value_ticks) tick.value *= unit;
  chart.most_value = chart.value_ticks.back().value;
  chart.zoom_ticks = zoom_ticks(chart.most_zoom);
}

double log_distance(double a, double b) { return std::abs(std::log(a / b)); }

const ZoomPoint& nearest_point(const ZoomCurve& curve, double zoom) {
  const auto distance = [&](const ZoomPoint& point) { return log_distance(point.zoom, zoom); };
  return *std::ranges::min_element(curve.points, {}, distance);
}

// True if no other step of the curve's recording is nearer.
bool is_at(const ZoomCurve& curve, const ZoomPoint& point, double zoom) {
  constexpr double kSameZoom = 1e-6;
  const std::size_t count = curve.points.size();
  const double apart = count < 2
                           ? 0
                           : log_distance(curve.points.back().zoom, curve.points.front().zoom) /
                                 static_cast<double>(count - 1);
  return log_distance(point.zoom, zoom) <= 0.5 * apart + kSameZoom;
}

// Three significant digits; pairs are counts.
std::string value_text(double value) {
  if (value >= 1000) return grouped(static_cast<std::uint64_t>(std::llround(value)));
  return fmt::format("{:.{}f}", value, value >= 100 ? 0 : value >= 10 ? 1 : 2);
}

std::vector<AxisTick> iteration_ticks(int most) {
  std::vector<AxisTick> ticks = round_ticks(std::max(most, 1));
  // An iteration is a whole number.
  std::erase_if(ticks, [](const AxisTick& tick) { return tick.value != std::floor(tick.value); });
  for (AxisTick& tick : ticks) tick.text = grouped(static_cast<std::uint64_t>(tick.value));
  return ticks;
}

IterationChart iteration_chart(int last, double least, double most) {
  IterationChart chart{.least = least,
                       .iteration_ticks = iteration_ticks(last),
                       .value_ticks = round_ticks(most - least)};
  for (AxisTick& tick : chart.value_ticks) tick.value += least;
  chart.most = chart.value_ticks.back().value;
  chart.most_iteration = chart.iteration_ticks.back().value;
  return chart;
}

}  // namespace

glm::dvec2 ZoomChart::place(double zoom, double value) const {
  return {std::log(zoom) / std::log(most_zoom), value / most_value};
}

ZoomChart zoom_chart(const ZoomRecord* shown, const ZoomRecord* beneath, ZoomQuantity quantity) {
  ZoomChart chart;
  chart.most_zoom = kLeastZoomRange;
  if (beneath == shown) beneath = nullptr;
  for (const ZoomRecord* record : {beneath, shown}) {
    if (record == nullptr) continue;
    add_curves(*record, quantity, record == beneath, chart.curves);
    chart.most_zoom = std::max(chart.most_zoom, 1 / record->closest);
  }
  set_axes(chart, quantity);
  return chart;
}

std::optional<ZoomReading> read_zoom_chart(const ZoomChart& chart, double x) {
  if (chart.empty()) return std::nullopt;
  // The last curve is of the recording that is shown, if it has points.
  const ZoomPoint& at =
      nearest_point(chart.curves.back(), std::pow(chart.most_zoom, std::clamp(x, 0.0, 1.0)));
  ZoomReading reading{at.zoom, fmt::format("{:.3g}x", at.zoom), {}};
  for (const ZoomCurve& curve : chart.curves) {
    const ZoomPoint& point = nearest_point(curve, at.zoom);
    if (!is_at(curve, point, at.zoom)) continue;
    auto row = std::ranges::find(reading.rows, curve.mode, &ZoomReading::Row::mode);
    if (row == reading.rows.end())
      row = reading.rows.insert(row, ZoomReading::Row{curve.mode, "", ""});
    (curve.is_beneath ? row->beneath : row->value) = value_text(point.value);
  }
  return reading;
}

IterationChart loss_chart(const std::vector<LossPoint>& losses) {
  double most = 0;
  for (const LossPoint& point : losses)
    if (std::isfinite(point.loss)) most = std::max(most, static_cast<double>(point.loss));
  return iteration_chart(losses.empty() ? 1 : losses.back().iteration, 0, most > 0 ? most : 1);
}

IterationChart psnr_chart(const std::vector<PsnrPoint>& points) {
  if (points.empty()) return {};
  const auto [low, high] = std::ranges::minmax(points, {}, &PsnrPoint::psnr);
  const double least = std::floor(low.psnr);
  IterationChart chart =
      iteration_chart(std::ranges::max(points, {}, &PsnrPoint::iteration).iteration, least,
                      std::max(high.psnr, least + 1));
  for (AxisTick& tick : chart.value_ticks) tick.text = fmt::format("{:g}", tick.value);
  return chart;
}

const LossPoint& loss_near(const std::vector<LossPoint>& losses, double iteration) {
  const auto distance = [&](const LossPoint& point) {
    return std::abs(point.iteration - iteration);
  };
  return *std::ranges::min_element(losses, {}, distance);
}

}  // namespace qs
