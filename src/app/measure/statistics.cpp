// SPDX-License-Identifier: MIT
#include "app/measure/statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <vector>

namespace qs {

double percentile(std::span<const double> values, double fraction) {
  assert(!values.empty());
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const double place = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], place - static_cast<double>(below));
}

Summary summarise(std::span<const double> values) {
  if (values.empty()) return {};
  Summary summary;
  summary.median = median(values);
  summary.p05 = percentile(values, 0.05);
  summary.p95 = percentile(values, 0.95);
  summary.mean =
      std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  const std::size_t half = values.size() / 2;
  if (half > 0) {
    const double first = median(values.first(half)), second = median(values.last(half));
    if (first > 0) summary.drift = second / first - 1;
  }
  return summary;
}

std::optional<double> quartile_spread(std::span<const double> values) {
  if (values.size() < 2) return std::nullopt;
  return (percentile(values, 0.75) - percentile(values, 0.25)) / 2;
}

double relative_spread(std::span<const double> values) {
  if (values.size() < 2) return 0;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double middle = median(values);
  return middle > 0 ? (*high - *low) / middle : 0;
}

}  // namespace qs
