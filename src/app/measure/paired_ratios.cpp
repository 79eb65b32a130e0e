// SPDX-License-Identifier: MIT
#include "app/measure/paired_ratios.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include <fmt/format.h>

#include "app/measure/statistics.h"
#include "base/list_of.h"

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

// The ratios of the cameras of a scene, pipeline and mode, and the rows behind them.
struct RatioGroup {
  std::vector<PairedRatio> ratios;
  std::vector<const BenchRow*> rows;
};

PairedRatio over_cameras(const std::vector<PairedRatio>& cameras) {
  PairedRatio result = cameras.front();
  result.camera.clear();
  if (cameras.size() == 1) return result;
  const auto value_of = [](const PairedRatio& camera) { return camera.ratio.value; };
  result.ratio = geometric_mean(list_of<double>(cameras, value_of));
  return result;
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

std::optional<std::uint64_t> all_frames(std::span<const BenchRow* const> rows) {
  std::uint64_t sum = 0;
  for (const BenchRow* row : rows) {
    if (!row->frames) return std::nullopt;
    sum += *row->frames;
  }
  return sum;
}

std::optional<Ratio> ratio_of_times(std::span<const double> base_ms, std::span<const double> ms) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(base_ms.size(), ms.size()); ++i)
    if (base_ms[i] > 0 && ms[i] > 0) ratios.push_back(base_ms[i] / ms[i]);
  return ratios.empty() ? std::nullopt : std::optional(geometric_mean(ratios));
}

std::optional<Ratio> paired_ratio(const BenchRow& base, const BenchRow& row) {
  if (base.turn_ms && row.turn_ms && base.turn_ms->size() == row.turn_ms->size())
    return ratio_of_times(*base.turn_ms, *row.turn_ms);
  return ratio_of_times(rounds_of(base), rounds_of(row));
}

std::vector<PairedRatio> paired_ratios(const std::vector<BenchRow>& rows,
                                       const std::string& baseline) {
  std::map<ViewKey, const BenchRow*> bases;
  for (const BenchRow& row : rows)
    if (row.mode == baseline) bases.emplace(view_of(row), &row);
  std::vector<RatioGroup> groups;
  for (const BenchRow& row : rows) {
    const auto base = bases.find(view_of(row));
    if (row.mode == baseline || base == bases.end()) continue;
    const std::optional<Ratio> ratio = paired_ratio(*base->second, row);
    if (!ratio) continue;
    auto group = std::ranges::find_if(groups, [&](const RatioGroup& members) {
      const PairedRatio& other = members.ratios.front();
      return other.scene == row.scene && other.mode == row.mode && other.pipeline == row.pipeline;
    });
    if (group == groups.end()) group = groups.emplace(group);
    group->ratios.push_back({row.scene, row.camera, row.mode, row.pipeline, *ratio});
    group->rows.push_back(&row);
  }
  std::vector<PairedRatio> ratios;
  for (const auto& [cameras, behind] : groups) {
    for (std::size_t i = 0; i < cameras.size(); ++i)
      if (are_enough_frames(behind[i]->frames)) ratios.push_back(cameras[i]);
    if (are_enough_frames(all_frames(behind))) ratios.push_back(over_cameras(cameras));
  }
  return ratios;
}

}  // namespace qs
