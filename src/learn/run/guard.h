// SPDX-License-Identifier: MIT
//
// The guard against overfitting: a few training views are reserved until 0.8 of the run. They are
// compared with the model from time to time, beside as many trained views. If they get worse while
// the trained views get better, the model has begun to remember its photographs: the strategy stops
// growth. At the end the reserved views are trained too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "learn/run/pace.h"

namespace qs::train {

/// Mean PSNR after an iteration, in dB.
struct GuardRow {
  int iteration = 0;
  double reserved = 0, trained = 0;
};

/// Everything follows from the settings, the number of views and the measurements.
class Guard {
 public:
  /// Reserves no view.
  Guard() = default;
  /// Reserves max(3, views / 20) views, but at most a quarter, evenly over the views' order: no two
  /// are neighbours. `rows`
  /// are the measurements so far.
  Guard(std::size_t views, std::uint64_t seed, std::vector<GuardRow> rows);

  /// Views by their numbers, ascending.
  const std::vector<std::size_t>& reserved() const { return reserved_; }
  const std::vector<std::size_t>& trained() const { return trained_; }
  /// The trained view next to each reserved view.
  std::vector<std::size_t> neighbours() const;

  /// True if a measurement after this iteration is missing: it is due every fortieth of the run,
  /// after the first tenth, while views are reserved.
  bool due(const Pace& pace, int iteration) const;
  void add(const GuardRow& row);
  const std::vector<GuardRow>& rows() const { return rows_; }

  /// The iteration after which growth stops; 0: it does not. That is when the last three
  /// measurements of the reserved views are 0.1 dB below the best one, while one of the trained
  /// views is 0.1 dB better than then.
  int stopped_after() const { return stopped_after_; }
  /// True if this iteration may train the reserved views.
  bool trains_all(const Pace& pace, int iteration) const;

  /// The verdict, a sentence; "" without reserved views.
  std::string verdict() const;

 private:
  std::vector<std::size_t> reserved_, trained_;
  std::vector<GuardRow> rows_;
  int stopped_after_ = 0, best_after_ = 0;
  double best_ = 0, best_trained_ = 0;  // of the last three measurements, at the best time
};

}  // namespace qs::train
