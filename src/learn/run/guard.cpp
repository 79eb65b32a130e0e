// SPDX-License-Identifier: MIT
#include "learn/run/guard.h"

#include <algorithm>
#include <cstdint>

#include <fmt/format.h>

#include "base/list_of.h"
#include "base/text.h"
#include "raster/kernel/random.h"

namespace qs::train {
namespace {

constexpr std::size_t kLeastReserved = 3, kViewsPerReserved = 20, kViewsOfMost = 4;
constexpr int kMeasurements = 40, kCompared = 3;
constexpr double kTolerance = 0.1;  // dB

constexpr double kMeasuresFrom = 0.1, kReleasesAfter = 0.8;  // times of the schedule

}  // namespace

Guard::Guard(std::size_t views, std::uint64_t seed, std::vector<GuardRow> rows) {
  const std::size_t count =
      std::min(std::max(kLeastReserved, views / kViewsPerReserved), views / kViewsOfMost);
  const double shift = Random::of(seed, RandomUse::views, ~std::uint64_t{0}).uniform(0);
  for (std::size_t i = 0; i < count; ++i) {
    const double at = (static_cast<double>(i) + shift) / static_cast<double>(count);
    reserved_.push_back(static_cast<std::size_t>(at * static_cast<double>(views)));
  }
  for (std::size_t i = 0; i < views; ++i)
    if (!std::ranges::binary_search(reserved_, i)) trained_.push_back(i);
  for (const GuardRow& row : rows) add(row);
}

std::vector<std::size_t> Guard::neighbours() const {
  return list_of<std::size_t>(reserved_,
                              [](std::size_t view) { return view > 0 ? view - 1 : view + 1; });
}

bool Guard::due(const Pace& pace, int iteration) const {
  if (reserved_.empty() || pace.time(iteration) <= kMeasuresFrom || trains_all(pace, iteration))
    return false;
  const bool is_mark =
      pace.steps(iteration, 0, 1, kMeasurements) > pace.steps(iteration - 1, 0, 1, kMeasurements);
  return is_mark && (rows_.empty() || rows_.back().iteration < iteration);
}

void Guard::add(const GuardRow& row) {
  rows_.push_back(row);
  if (rows_.size() < kCompared || stopped_after_ > 0) return;
  // The best of each, because a measurement behind a halving of opacities is lower.
  double reserved = row.reserved, trained = row.trained;
  for (auto i = rows_.end() - kCompared; i != rows_.end(); ++i) {
    reserved = std::max(reserved, i->reserved);
    trained = std::max(trained, i->trained);
  }
  if (best_after_ == 0 || reserved > best_) {
    best_ = reserved;
    best_trained_ = trained;
    best_after_ = row.iteration;
  } else if (reserved < best_ - kTolerance && trained > best_trained_ + kTolerance) {
    stopped_after_ = row.iteration;
  }
}

bool Guard::trains_all(const Pace& pace, int iteration) const {
  return reserved_.empty() || pace.time(iteration) > kReleasesAfter;
}

std::string Guard::verdict() const {
  if (rows_.empty()) return "";
  const auto number = [](int n) { return grouped(static_cast<std::uint64_t>(n)); };
  const std::string views = fmt::format("{} reserved views", reserved_.size());
  const std::string last = fmt::format("{} dB after iteration {}", decibels(rows_.back().reserved),
                                       number(rows_.back().iteration));
  if (stopped_after_ == 0) return fmt::format("the {} did not get worse: {}", views, last);
  return fmt::format(
      "growth stopped after iteration {}, because the {} got worse since iteration {} ({} "
      "dB); {}",
      number(stopped_after_), views, number(best_after_), decibels(best_), last);
}

}  // namespace qs::train
