// SPDX-License-Identifier: MIT
#include "app/measure/paired_ratios.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include <fmt/format.h>

#include "app/measure/number_text.h"

namespace qs {
namespace {

// The probability that |t| <= sqrt(degrees) * tan(angle): Abramowitz and Stegun, 26.7.3 and 26.7.4.
double central_probability(double angle, std::size_t degrees) {
  const double cosine = std::cos(angle);
  const bool odd = degrees % 2 == 1;
  double term = std::sin(angle) * (odd ? cosine : 1), sum = 0;
  for (std::size_t k = odd ? 3 : 2; k <= degrees; k += 2) {
    sum += term;
    term *= cosine * cosine * static_cast<double>(k - 1) / static_cast<double>(k);
  }
  return odd ? 2 / std::numbers::pi * (angle + sum) : sum;
}

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

double student_t95(std::size_t degrees) {
  assert(degrees > 0);
  double low = 0, high = std::numbers::pi / 2;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (central_probability(middle, degrees) < 0.95 ? low : high) = middle;
  }
  return std::sqrt(static_cast<double>(degrees)) * std::tan(low);
}

Ratio geometric_mean(std::span<const double> ratios) {
  assert(!ratios.empty());
  const auto count = static_cast<double>(ratios.size());
  double mean = 0, squares = 0;
  for (const double ratio : ratios) mean += std::log(ratio) / count;
  for (const double ratio : ratios) squares += std::pow(std::log(ratio) - mean, 2);
  Ratio result{std::exp(mean), std::nullopt, ratios.size()};
  if (ratios.size() > 1) {
    const double half = student_t95(ratios.size() - 1) * std::sqrt(squares / (count - 1) / count);
    result.interval = {std::exp(mean - half), std::exp(mean + half)};
  }
  return result;
}

double half_interval(const Ratio& ratio) {
  return std::max(ratio.interval->high - ratio.value, ratio.value - ratio.interval->low);
}

bool is_undecided(const Ratio& ratio) {
  return ratio.interval && ratio.interval->low <= 1 && ratio.interval->high >= 1;
}

std::string ratio_text(const Ratio& ratio) {
  if (!ratio.interval) return fmt::format("{:.2f}x", ratio.value);
  const double half = half_interval(ratio);
  return fmt::format("{}x \u00b1{}{}", significant(ratio.value, half), significant(half, half),
                     is_undecided(ratio) ? " noisy" : "");
}

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
