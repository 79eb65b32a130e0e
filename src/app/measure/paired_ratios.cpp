// SPDX-License-Identifier: MIT
#include "app/measure/paired_ratios.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace qs {
namespace {

using ViewKey = std::tuple<std::string, std::string, std::uint64_t>;  // scene, pipeline, view

ViewKey view_of(const BenchRow& row) { return {row.scene, row.pipeline, row.view}; }

bool same_group(const PairedRatio& ratio, const BenchRow& row) {
  return ratio.scene == row.scene && ratio.mode == row.mode && ratio.pipeline == row.pipeline;
}

PairedRatio over_cameras(const std::vector<PairedRatio>& cameras) {
  PairedRatio result = cameras.front();
  result.camera.clear();
  if (cameras.size() == 1) return result;
  std::vector<double> values;
  for (const PairedRatio& camera : cameras) values.push_back(camera.ratio.value);
  result.ratio = geometric_mean(values);
  return result;
}

}  // namespace

std::vector<double> rounds_of(const BenchRow& row) {
  return row.round_ms.empty() ? std::vector<double>{row.ms_median} : row.round_ms;
}

std::optional<Ratio> paired_ratio(const BenchRow& base, const BenchRow& row) {
  const std::vector<double> base_ms = rounds_of(base), ms = rounds_of(row);
  std::vector<double> ratios;
  for (std::size_t round = 0; round < std::min(base_ms.size(), ms.size()); ++round) {
    if (base_ms[round] > 0 && ms[round] > 0) ratios.push_back(base_ms[round] / ms[round]);
  }
  if (ratios.empty()) return std::nullopt;
  return geometric_mean(ratios);
}

std::vector<PairedRatio> paired_ratios(const std::vector<BenchRow>& rows,
                                       const std::string& baseline) {
  std::map<ViewKey, const BenchRow*> bases;
  for (const BenchRow& row : rows) {
    if (row.mode == baseline) bases.emplace(view_of(row), &row);
  }
  std::vector<std::vector<PairedRatio>> groups;
  for (const BenchRow& row : rows) {
    const auto base = bases.find(view_of(row));
    if (row.mode == baseline || base == bases.end()) continue;
    const std::optional<Ratio> ratio = paired_ratio(*base->second, row);
    if (!ratio) continue;
    const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& members) {
      return same_group(members.front(), row);
    });
    (group == groups.end() ? groups.emplace_back() : *group)
        .push_back({row.scene, row.camera, row.mode, row.pipeline, *ratio});
  }
  std::vector<PairedRatio> ratios;
  for (const std::vector<PairedRatio>& group : groups) {
    ratios.insert(ratios.end(), group.begin(), group.end());
    ratios.push_back(over_cameras(group));
  }
  return ratios;
}

}  // namespace qs
