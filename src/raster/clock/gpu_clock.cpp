// SPDX-License-Identifier: MIT
#include "raster/clock/gpu_clock.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text.h"

namespace qs {
namespace {

/// Range of a value over the readings that have it; unset if none has. The median is the value of a
/// reading.
template <class ValueOf>
std::optional<SensorRange> range_of(const std::vector<GpuReading>& readings,
                                    const ValueOf& value_of) {
  std::vector<double> values;
  for (const GpuReading& reading : readings)
    if (const std::optional<double> value = value_of(reading)) values.push_back(*value);
  if (values.empty()) return std::nullopt;
  std::ranges::sort(values);
  return SensorRange{values[values.size() / 2], values.front(), values.back()};
}

std::optional<std::vector<std::string>> throttles_of(const std::vector<GpuReading>& readings) {
  std::optional<std::vector<std::string>> all;
  for (const GpuReading& reading : readings) {
    if (!reading.throttles) continue;
    if (!all) all.emplace();
    for (const std::string& reason : *reading.throttles) add_new(*all, reason);
  }
  return all;
}

std::string grouped_mhz(double mhz) {
  return grouped(static_cast<std::uint64_t>(std::lround(mhz)));
}

/// " (1,755 to 1,980, at most 1,980)", or "" for a clock that was at its maximum all the time.
std::string variation(const GpuClockSummary& summary) {
  const SensorRange& mhz = summary.sm_mhz;
  std::vector<std::string> words;
  if (mhz.min < mhz.max)
    words.push_back(fmt::format("{} to {}", grouped_mhz(mhz.min), grouped_mhz(mhz.max)));
  if (summary.sm_mhz_max && mhz.median < *summary.sm_mhz_max)
    words.push_back(fmt::format("at most {}", grouped_mhz(*summary.sm_mhz_max)));
  return words.empty() ? "" : fmt::format(" ({})", fmt::join(words, ", "));
}

}  // namespace

void GpuClock::sample(Time now) {
  if (!sensors_.read || (last_ && now - *last_ < kInterval)) return;
  last_ = now;
  if (std::optional<GpuReading> reading = sensors_.read()) readings_.push_back(std::move(*reading));
}

std::optional<GpuClockSummary> GpuClock::summary() const {
  if (readings_.empty()) return std::nullopt;
  const auto range = [&](const auto& value_of) { return range_of(readings_, value_of); };
  return GpuClockSummary{
      .readings = readings_.size(),
      .sm_mhz = *range([](const GpuReading& reading) { return std::optional(reading.sm_mhz); }),
      .sm_mhz_max = sensors_.sm_mhz_max,
      .throttled = throttles_of(readings_),
      .celsius = range([](const GpuReading& reading) { return reading.celsius; }),
      .watts = range([](const GpuReading& reading) { return reading.watts; })};
}

std::string clock_text(const std::string& gpu, const std::optional<GpuClockSummary>& summary) {
  if (!summary) return fmt::format("{}: SM clock unknown", gpu);
  const std::string throttling =
      !summary->throttled ? "throttling unknown"
      : summary->throttled->empty()
          ? "not throttled"
          : fmt::format("throttled: {}", fmt::join(*summary->throttled, ", "));
  return fmt::format("{}: SM clock {} MHz{}, {}", gpu, grouped_mhz(summary->sm_mhz.median),
                     variation(*summary), throttling);
}

std::string throttle_warning(const std::optional<GpuClockSummary>& summary) {
  if (!summary || !summary->throttled || summary->throttled->empty()) return "";
  return fmt::format(
      "the GPU was throttled during the measurement ({}), so its times may not be comparable with "
      "others",
      fmt::join(*summary->throttled, ", "));
}

}  // namespace qs
