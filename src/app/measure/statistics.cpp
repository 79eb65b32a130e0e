// SPDX-License-Identifier: MIT
#include "app/measure/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <fmt/format.h>

namespace qs {

double percentile(std::span<const double> values, double fraction) {
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const double place = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], place - static_cast<double>(below));
}

Summary summarise(std::span<const double> values) {
  if (values.empty()) return {};
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  Summary summary{median(values), percentile(values, 0.05), percentile(values, 0.95),
                  sum / static_cast<double>(values.size())};
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

std::string significant(double value, double uncertainty) {
  constexpr int kMostDecimals = 3;
  if (uncertainty <= 0) return fmt::format("{:.{}f}", value, kMostDecimals);
  const int decimals =
      std::min(kMostDecimals, -static_cast<int>(std::floor(std::log10(uncertainty))));
  if (decimals >= 0) return fmt::format("{:.{}f}", value, decimals);
  const double unit = std::pow(10.0, -decimals);
  return fmt::format("{:.0f}", std::round(value / unit) * unit);
}

std::string ms_text(double ms) { return fmt::format("{:.3f}", ms); }
std::string fps_text(double fps) { return fmt::format("{:.{}f}", fps, fps < 1000 ? 1 : 0); }

std::string time_text(double ms, std::optional<double> spread_ms) {
  if (!spread_ms) return ms_text(ms);
  return fmt::format("{} \u00b1{}", significant(ms, *spread_ms),
                     significant(*spread_ms, *spread_ms));
}

bool times_bin(const BenchRow& row) {
  const bool fast = row.pipeline == kPipelineNames[static_cast<int>(Pipeline::fast)];
  const bool cuda = row.backend == kBackendNames[static_cast<int>(Backend::cuda)];
  return is_timed(cuda ? Backend::cuda : Backend::cpu, fast ? Pipeline::fast : Pipeline::classic,
                  Stage::bin);
}

std::string stage_text(const BenchRow& row, Stage stage) {
  if (stage == Stage::bin && !times_bin(row)) return "in preprocess and sort";
  const double ms[kStageCount] = {row.preprocess_ms, row.bin_ms, row.sort_ms, row.blend_ms};
  return ms_text(ms[static_cast<int>(stage)]) + " ms";
}

std::string rate_text(double ms, std::optional<double> spread_ms) {
  const double fps = ms > 0 ? 1000 / ms : 0;
  if (!spread_ms || ms <= 0) return fps_text(fps);
  return significant(fps, std::max(fps * *spread_ms / ms, fps < 1000 ? 0.1 : 1.0));
}

}  // namespace qs
