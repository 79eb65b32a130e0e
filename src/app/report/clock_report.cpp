// SPDX-License-Identifier: MIT
#include "app/report/clock_report.h"

#include <algorithm>

namespace qs {
namespace {

using nlohmann::ordered_json;

constexpr const char* kKey = "gpu_clock";

template <class T>
ordered_json or_null(const std::optional<T>& value) {
  return value ? ordered_json(*value) : ordered_json();
}

ordered_json range_json(const std::optional<SensorRange>& range) {
  if (!range) return nullptr;
  return {{"median", range->median}, {"min", range->min}, {"max", range->max}};
}

/// The values of a report: several if it was merged.
std::vector<ordered_json> clocks_of(const ordered_json& environment) {
  const auto found = environment.find(kKey);
  if (found == environment.end()) return {};
  if (found->is_array()) return found->get<std::vector<ordered_json>>();
  return {*found};
}

void add_new(std::vector<std::string>& list, const std::string& text) {
  if (!text.empty() && std::find(list.begin(), list.end(), text) == list.end())
    list.push_back(text);
}

}  // namespace

GpuClock clock_of(const Session& session) {
  return GpuClock(session.backend == Backend::cuda ? gpu_sensors(session.device) : GpuSensors());
}

void add_clock(ordered_json& environment, const GpuClock& clock) {
  if (environment.value("backend", "") != kBackendNames[static_cast<int>(Backend::cuda)]) return;
  const std::optional<GpuClockSummary> summary = clock.summary();
  ordered_json& json = environment[kKey] = nullptr;
  if (!summary) return;
  json = {{"text", clock_text(environment.value("gpu", "unknown"), summary)},
          {"readings", summary->readings},
          {"sm_mhz", range_json(summary->sm_mhz)},
          {"sm_mhz_max", or_null(summary->sm_mhz_max)},
          {"throttled", or_null(summary->throttled)},
          {"warning", throttle_warning(summary)},
          {"celsius", range_json(summary->celsius)},
          {"watts", range_json(summary->watts)}};
}

std::vector<std::string> clock_lines(const ordered_json& environment) {
  std::vector<std::string> lines, warnings;
  for (const ordered_json& clock : clocks_of(environment)) {
    add_new(lines, clock.is_null() ? clock_text(environment.value("gpu", "unknown"), std::nullopt)
                                   : clock.value("text", ""));
    if (!clock.is_null()) add_new(warnings, clock.value("warning", ""));
  }
  for (const std::string& warning : warnings) lines.push_back("Warning: " + warning);
  return lines;
}

void merge_clocks(const std::vector<ordered_json>& parts, ordered_json& environment) {
  ordered_json all = ordered_json::array();
  for (const ordered_json& part : parts) {
    for (ordered_json& clock : clocks_of(part)) all.push_back(std::move(clock));
  }
  if (!all.empty()) environment[kKey] = std::move(all);
}

}  // namespace qs
