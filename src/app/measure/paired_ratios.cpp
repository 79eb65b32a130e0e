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

// A camera's ratio and the frames behind it.
struct CameraRatio {
  PairedRatio ratio;
  std::optional<std::uint64_t> frames;
};

PairedRatio over_cameras(const std::vector<CameraRatio>& cameras) {
  PairedRatio result = cameras.front().ratio;
  result.camera.clear();
  if (cameras.size() == 1) return result;
  std::vector<double> values;
  for (const CameraRatio& camera : cameras) values.push_back(camera.ratio.ratio.value);
  result.ratio = geometric_mean(values);
  return result;
}

std::optional<std::uint64_t> frames_of(const std::vector<CameraRatio>& cameras) {
  std::uint64_t sum = 0;
  for (const CameraRatio& camera : cameras) {
    if (!camera.frames) return std::nullopt;
    sum += *camera.frames;
  }
  return sum;
}

}  // namespace

std::vector<double> rounds_of(const BenchRow& row) {
  return row.round_ms.empty() ? std::vector<double>{row.ms_median} : row.round_ms;
}

std::optional<Ratio> paired_ratio(const BenchRow& base, const BenchRow& row) {
  std::vector<double> base_ms = rounds_of(base), ms = rounds_of(row);
  if (base.turn_ms && row.turn_ms && base.turn_ms->size() == row.turn_ms->size()) {
    base_ms = *base.turn_ms;
    ms = *row.turn_ms;
  }
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
  std::vector<std::vector<CameraRatio>> groups;
  for (const BenchRow& row : rows) {
    const auto base = bases.find(view_of(row));
    if (row.mode == baseline || base == bases.end()) continue;
    const std::optional<Ratio> ratio = paired_ratio(*base->second, row);
    if (!ratio) continue;
    const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& members) {
      return same_group(members.front().ratio, row);
    });
    (group == groups.end() ? groups.emplace_back() : *group)
        .push_back({{row.scene, row.camera, row.mode, row.pipeline, *ratio}, row.frames});
  }
  std::vector<PairedRatio> ratios;
  for (const std::vector<CameraRatio>& group : groups) {
    for (const CameraRatio& camera : group) {
      if (are_enough_frames(camera.frames)) ratios.push_back(camera.ratio);
    }
    if (are_enough_frames(frames_of(group))) ratios.push_back(over_cameras(group));
  }
  return ratios;
}

}  // namespace qs
