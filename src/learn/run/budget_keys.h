// SPDX-License-Identifier: MIT
//
// Developers' choices for strategy `budget`, from the environment variable QUADSPLAT_BUDGET, as
// "key=value,key=value". They go when the experiments have decided.
#pragma once

#include <string>

#include "learn/run/strategy.h"

namespace qs::train {

struct BudgetKeys {
  std::string base =
      "mcmc";  ///< mcmc, adc, few (strategy fastgs, with a schedule that follows the run)
  std::string score = "";         ///< opacity, gradient, flagged, share (flagged share x gradient)
  std::string child = "";         ///< relocate, beside, long
  std::string decay = "";         ///< none, half, mild:X, minus:X, clamp, reset
  std::string clear = "";         ///< all, opacity, none
  std::string prune = "opacity";  ///< opacity, unseen: in no pixel of the counted views
  double amount = 0;              ///< X of `decay`
  double mean_end = 1.6e-5, fall = 0.3, rest = 1.25e-4, divisor = 200;
  double noise = 1, penalty = 1, recover = 0, half = 0, guard = 1, sums = 0;
  double release =
      0;  ///< reserved views are trained from 0.8 also after the guard has stopped growth
  double replace = 1;  ///< score=opacity draws with replacement
  double count = -1;   ///< counted views before a change; -1: as score and prune need
};

/// Throws Error(usage) naming an unknown key or value.
const BudgetKeys& budget_keys();

/// The row with the values that keys change. The reference stays valid.
const Strategy& budget_with_keys(const Strategy& row);

}  // namespace qs::train
