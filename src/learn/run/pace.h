// SPDX-License-Identifier: MIT
//
// The time of a schedule that follows the run: it goes from 0 at the start to 1 at the end. With a
// number of iterations, every iteration is an equal share of it. With a number of seconds, the
// share is corrected during the run, by the measured speed. The corrections are recorded, and a run
// with the same record gives the same model.
#pragma once

#include <cstddef>
#include <vector>

namespace qs::train {

class Pace {
 public:
  /// After iteration `from`, every iteration is 1 / `iterations` of the run.
  struct Row {
    int from = 0, iterations = 1;
    bool operator==(const Row&) const = default;
  };

  explicit Pace(int iterations = 1) { correct(0, iterations); }
  /// The rows ascend from 0.
  explicit Pace(const std::vector<Row>& rows) {
    for (const Row& row : rows) correct(row.from, row.iterations);
  }

  /// The time after an iteration, 0 before the first; 1 at the end.
  double time(int iteration) const;
  /// The iteration after which the time is first at least `time`, 0..1.
  int iteration_at(double time) const;
  int end() const { return iteration_at(1); }
  /// The number of `count` equal steps from time `begin` to time `end` that are complete after an
  /// iteration.
  int steps(int iteration, double begin, double end, int count) const;

  /// Sets the share of the iterations after `from`, which is not before the last row.
  void correct(int from, int iterations);

  const std::vector<Row>& rows() const { return rows_; }
  /// The number of iterations of a whole run at the pace of this iteration.
  int iterations_in(int iteration) const { return rows_[row_of(iteration)].iterations; }

 private:
  std::size_t row_of(int iteration) const;  ///< an index into rows_

  std::vector<Row> rows_;
  std::vector<double> starts_;  ///< of every row: the time after iteration `from`
};

/// Corrects a pace so that a run ends after a number of seconds.
class PaceControl {
 public:
  /// The run has taken `elapsed` seconds until `iteration`.
  explicit PaceControl(double seconds, double elapsed = 0, int iteration = 0)
      : seconds_(seconds), last_{elapsed, iteration} {}

  /// Corrects `pace` after an iteration, if some time has passed since the last correction.
  /// `elapsed` are the seconds so far, and the number of Gaussians is expected to grow from
  /// `gaussians` to `target` until time `growth_end`.
  void correct(double elapsed, int iteration, double gaussians, double target, double growth_end,
               Pace& pace);

 private:
  struct Sample {
    double elapsed = 0;
    int iteration = 0;
  };

  double seconds_;
  Sample last_;
  double first_speed_ = 0, first_gaussians_ = 0;  // seconds per iteration, at the first correction
};

}  // namespace qs::train
