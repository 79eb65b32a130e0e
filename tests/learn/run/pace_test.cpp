// SPDX-License-Identifier: MIT
// The time of schedules that follow the run, and its corrections by measured speed.
#include "learn/run/pace.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace qs::train {
namespace {

TEST(Pace, every_iteration_is_an_equal_share_of_the_run) {
  for (const int iterations : {1, 2, 7, 100, 999, 10'000, 30'000, 1'234'567}) {
    const Pace pace(iterations);
    EXPECT_EQ(pace.time(0), 0) << iterations;
    EXPECT_EQ(pace.time(iterations), 1) << iterations;
    EXPECT_EQ(pace.end(), iterations);
    EXPECT_EQ(pace.steps(iterations, 0.05, 0.7, 60), 60) << iterations;
    EXPECT_EQ(pace.steps(0, 0.05, 0.7, 60), 0) << iterations;
    EXPECT_EQ(pace.iterations_in(iterations), iterations);
  }
  const Pace pace(1000);
  EXPECT_EQ(pace.iteration_at(0.7), 700);
  EXPECT_EQ(pace.steps(699, 0.05, 0.7, 13), 12);
  EXPECT_EQ(pace.steps(700, 0.05, 0.7, 13), 13);
}

TEST(Pace, a_correction_changes_the_share_of_later_iterations_only) {
  Pace pace(1000);
  pace.correct(100, 500);
  pace.correct(300, 1000);
  EXPECT_DOUBLE_EQ(pace.time(100), 0.1);
  EXPECT_DOUBLE_EQ(pace.time(101), 0.1 + 1.0 / 500);
  EXPECT_DOUBLE_EQ(pace.time(300), 0.5);
  EXPECT_EQ(pace.end(), 800);
  EXPECT_EQ(pace.iteration_at(0.5), 300);
  EXPECT_EQ(pace.iteration_at(0.3), 200);
  EXPECT_EQ(pace.iterations_in(100), 1000);
  EXPECT_EQ(pace.iterations_in(101), 500);
  EXPECT_EQ(Pace(pace.rows()).time(777), pace.time(777)) << "from its record";
  double before = 0;
  for (int i = 1; i <= 800; ++i) {
    EXPECT_GT(pace.time(i), before) << i;
    before = pace.time(i);
  }
}

/// A machine: the seconds of an iteration with a number of Gaussians are a line.
struct Machine {
  double base, per_gaussian;
  double target, seconds;
};

TEST(Pace, a_run_of_given_seconds_ends_within_a_tenth_of_them) {
  constexpr Machine kMachines[] = {
      {0.7e-3, 0, 2e5, 10},      {0.5e-3, 2e-9, 2e5, 2}, {0.5e-3, 2e-9, 1e6, 20},
      {0.2e-3, 1e-8, 1e6, 45},   {0.2e-3, 1e-8, 1e6, 5}, {1e-3, 0, 1e4, 60},
      {0.0, 1e-8, 4e5, 10},      {0.05, 1e-6, 2e4, 20},  {0.3, 1e-5, 2e4, 30},
      {0.5e-3, 1e-9, 1000, 0.5},
  };
  for (const Machine& machine : kMachines) {
    Pace pace(30'000);
    PaceControl control(machine.seconds);
    double elapsed = 0.05 * machine.seconds / 10;  // the device starts slowly
    int iteration = 0;
    while (iteration < pace.end()) {
      const double grown = std::clamp((pace.time(iteration) - 0.05) / 0.65, 0.0, 1.0);
      const double gaussians = 5000 + (machine.target - 5000) * grown;
      elapsed += machine.base + machine.per_gaussian * gaussians;
      control.correct(elapsed, ++iteration, gaussians, machine.target, 0.7, pace);
    }
    EXPECT_NEAR(elapsed, machine.seconds, 0.1 * machine.seconds)
        << machine.base << ", " << machine.per_gaussian << ", " << iteration;
    EXPECT_GE(pace.time(iteration), 1 - 1e-6);
    EXPECT_LE(pace.rows().size(), 52u);
  }
}

}  // namespace
}  // namespace qs::train
