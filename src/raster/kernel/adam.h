// SPDX-License-Identifier: MIT
//
// One step of Adam (Kingma and Ba 2015) for one value, as both backends take it.
#pragma once

#include <cmath>
#include <cstdint>

#include "raster/kernel/hd.h"

namespace qs {

inline constexpr double kAdamBeta1 = 0.9, kAdamBeta2 = 0.999, kAdamEpsilon = 1e-15;

/// The learning rate of each kind of parameter.
struct Rates {
  double mean = 0, log_scale = 0, rotation = 0, opacity = 0, sh_dc = 0, sh_rest = 0, mask = 0;
};

/// The values that a step shares between all parameters: the corrections of the moments' start at
/// 0.
struct AdamStep {
  float first, second;  ///< 1 / (1 - beta1^t) and 1 / sqrt(1 - beta2^t) of step t = 1, 2, ...

  static AdamStep number(std::uint64_t t) {
    const auto power = static_cast<double>(t);
    return {static_cast<float>(1 / (1 - std::pow(kAdamBeta1, power))),
            static_cast<float>(1 / std::sqrt(1 - std::pow(kAdamBeta2, power)))};
  }
};

/// Adds to a sum of gradients. A gradient that is not finite adds nothing.
QS_HD void add_gradient(float gradient, float& sum) {
  if (gradient - gradient == 0.0f) sum += gradient;
}

/// Moves `value` and updates its moments `first` and `second`, which start at 0. `step` is
/// AdamStep::number(t) of the current step t >= 1. A gradient that is not finite counts as 0, so
/// that no value ever becomes NaN.
QS_HD void adam(const AdamStep& step, float rate, float gradient, float& value, float& first,
                float& second) {
  constexpr auto kBeta1 = static_cast<float>(kAdamBeta1), kBeta2 = static_cast<float>(kAdamBeta2);
  constexpr auto kRest1 = static_cast<float>(1 - kAdamBeta1),
                 kRest2 = static_cast<float>(1 - kAdamBeta2);
  if (!(gradient - gradient == 0.0f)) gradient = 0.0f;
  first = kBeta1 * first + kRest1 * gradient;
  second = kBeta2 * second + kRest2 * gradient * gradient;
  const float size = std::sqrt(second) * step.second + static_cast<float>(kAdamEpsilon);
  const float move = rate * step.first * first / size;
  if (move - move == 0.0f) value = value - move;
}

}  // namespace qs
