// SPDX-License-Identifier: MIT
#include "app/viewer/state/loss_chart.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"

namespace qs {

LossChart loss_chart(const std::vector<LossPoint>& losses) {
  double most = 0;
  for (const LossPoint& point : losses)
    if (std::isfinite(point.loss)) most = std::max(most, static_cast<double>(point.loss));
  LossChart chart;
  chart.loss_ticks = round_ticks(most > 0 ? most : 1);
  chart.most_loss = chart.loss_ticks.back().value;
  const int last = losses.empty() ? 1 : losses.back().iteration;
  chart.iteration_ticks = round_ticks(std::max(last, 1));
  // An iteration is a whole number.
  std::erase_if(chart.iteration_ticks,
                [](const AxisTick& tick) { return tick.value != std::floor(tick.value); });
  for (AxisTick& tick : chart.iteration_ticks)
    tick.text = grouped(static_cast<std::uint64_t>(tick.value));
  chart.most_iteration = chart.iteration_ticks.back().value;
  return chart;
}

const LossPoint& loss_near(const std::vector<LossPoint>& losses, double iteration) {
  return *std::min_element(
      losses.begin(), losses.end(), [&](const LossPoint& a, const LossPoint& b) {
        return std::abs(a.iteration - iteration) < std::abs(b.iteration - iteration);
      });
}

}  // namespace qs
