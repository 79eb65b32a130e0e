// SPDX-License-Identifier: MIT
//
// The step by which residual codes in training follow their vectors (learn/field/code_training.h).
#pragma once

#include <cmath>
#include <cstddef>

#include "learn/gradient/adam.h"
#include "raster/kernel/hd.h"

namespace qs {

/// The derivative of the mean squared difference, over `values` values of all vectors, by a value
/// of a code: `sum` adds up the differences to the code's vectors.
QS_HD float code_gradient(double sum, std::size_t values) {
  return static_cast<float>(2 / static_cast<double>(values) * sum);
}

/// Adam's step of one value of a code, with rate 1e-4 and epsilon 1e-8. A gradient that is not
/// finite counts as 0.
QS_HD void move_code(const AdamStep& step, float gradient, float& value, float& first,
                     float& second) {
  constexpr float kRate = 1e-4f, kEpsilon = 1e-8f;
  constexpr auto kRest1 = static_cast<float>(1 - kAdamBeta1),
                 kRest2 = static_cast<float>(1 - kAdamBeta2);
  if (!(gradient - gradient == 0.0f)) gradient = 0.0f;
  first += kRest1 * (gradient - first);
  second += kRest2 * (gradient * gradient - second);
  value -= kRate * step.first * first / (std::sqrt(second) * step.second + kEpsilon);
}

}  // namespace qs
