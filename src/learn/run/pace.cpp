// SPDX-License-Identifier: MIT
#include "learn/run/pace.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace qs::train {
namespace {

constexpr double kTimeRounding = 1e-9;        // of times
constexpr double kBetweenCorrections = 0.02;  // of the seconds
constexpr double kGrown = 1.1;  // more Gaussians than at first: their share of the time is known
constexpr double kMostPaceIterations = 10'000'000;

}  // namespace

std::size_t Pace::row_of(int iteration) const {
  std::size_t row = rows_.size() - 1;
  while (row > 0 && rows_[row].from >= iteration) --row;
  return row;
}

double Pace::time(int iteration) const {
  const std::size_t row = row_of(iteration);
  return starts_[row] + static_cast<double>(iteration - rows_[row].from) / rows_[row].iterations;
}

int Pace::iteration_at(double time) const {
  std::size_t row = rows_.size() - 1;
  while (row > 0 && starts_[row] >= time) --row;
  const double length = (time - starts_[row] - kTimeRounding) * rows_[row].iterations;
  return rows_[row].from + std::max(0, static_cast<int>(std::ceil(length)));
}

int Pace::steps(int iteration, double begin, double end, int count) const {
  const double share = (time(iteration) - begin) / (end - begin);
  return std::clamp(static_cast<int>(std::floor(count * share + kTimeRounding)), 0, count);
}

void Pace::correct(int from, int iterations) {
  starts_.push_back(rows_.empty() ? 0 : time(from));
  rows_.push_back({from, iterations});
}

void PaceControl::correct(double elapsed, int iteration, double gaussians, double target,
                          double growth_end, Pace& pace) {
  const double passed = elapsed - last_.elapsed;
  const int made = iteration - last_.iteration;
  if (made <= 0 || passed < kBetweenCorrections * seconds_) return;
  const bool is_start = last_.iteration == 0;  // a device may be slow at first
  last_ = {elapsed, iteration};
  const double time = pace.time(iteration);
  if (is_start && passed < 2 * kBetweenCorrections * seconds_) return;
  const double speed = passed / made;
  if (first_speed_ == 0) {
    first_speed_ = speed;
    first_gaussians_ = gaussians;
  }
  if (time >= 1) return;
  // The mean number of Gaussians in the rest of the run, and the time that they will take more.
  double mean = gaussians;
  if (time < growth_end && target > gaussians)
    mean =
        ((gaussians + target) / 2 * (growth_end - time) + target * (1 - growth_end)) / (1 - time);
  double expected = speed;
  if (gaussians > kGrown * first_gaussians_)
    expected +=
        std::max(0.0, speed - first_speed_) / (gaussians - first_gaussians_) * (mean - gaussians);
  const double left = std::max(1.0, (seconds_ - elapsed) / expected);
  pace.correct(iteration,
               static_cast<int>(std::clamp(left / (1 - time), 1.0, kMostPaceIterations)));
}

}  // namespace qs::train
