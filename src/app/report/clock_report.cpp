// SPDX-License-Identifier: MIT
#include "app/report/clock_report.h"

#include <algorithm>

#include "base/json_of.h"
#include "base/text.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

constexpr const char *kClock = "gpu_clock", *kText = "gpu_clock_text";

ordered_json range_json(const std::optional<SensorRange>& range) {
  if (!range) return nullptr;
  return {{"median", range->median}, {"min", range->min}, {"max", range->max}};
}

}  // namespace

GpuClock clock_of(const Session& session) {
  return GpuClock(session.backend == Backend::cuda ? gpu_sensors(session.device) : GpuSensors());
}

void add_clock(ordered_json& environment, const GpuClock& clock) {
  if (environment.value("backend", "") != kBackendNames[static_cast<int>(Backend::cuda)]) return;
  const std::optional<GpuClockSummary> summary = clock.summary();
  environment[kClock] = nullptr;
  if (summary) {
    environment[kClock] = {{"readings", summary->readings},
                           {"sm_mhz", range_json(summary->sm_mhz)},
                           {"sm_mhz_max", json_of(summary->sm_mhz_max)},
                           {"throttled", json_of(summary->throttled)},
                           {"celsius", range_json(summary->celsius)},
                           {"watts", range_json(summary->watts)}};
  }
  environment[kText] =
      ordered_json::array({clock_text(environment.value("gpu", "unknown"), summary)});
  if (const std::string warning = throttle_warning(summary); !warning.empty())
    environment[kText].push_back("Warning: " + warning);
}

std::vector<std::string> clock_lines(const ordered_json& environment) {
  return environment.value(kText, std::vector<std::string>());
}

void merge_clocks(const std::vector<ordered_json>& parts, ordered_json& environment) {
  ordered_json clocks = ordered_json::array();
  std::vector<std::string> lines;
  for (const ordered_json& part : parts) {
    if (!part.contains(kClock)) continue;
    if (part[kClock].is_array()) {
      clocks.insert(clocks.end(), part[kClock].begin(), part[kClock].end());
    } else {
      clocks.push_back(part[kClock]);
    }
    for (const std::string& line : clock_lines(part)) add_new(lines, line);
  }
  if (clocks.empty()) return;
  environment[kClock] = std::move(clocks);
  environment[kText] = std::move(lines);
}

}  // namespace qs
