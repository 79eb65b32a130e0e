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

struct AdamRule {
  float beta1, beta2;  ///< the shares of the moments that a step keeps, at least 0 and below 1
  float rest1, rest2;  ///< 1 - beta
  float epsilon;       ///< added to the root of the second moment, so that it divides

  QS_HD static constexpr AdamRule of(double beta1, double beta2, double epsilon) {
    return {static_cast<float>(beta1), static_cast<float>(beta2), static_cast<float>(1 - beta1),
            static_cast<float>(1 - beta2), static_cast<float>(epsilon)};
  }
};

/// The values that a step shares between all parameters: the corrections of the moments' start at
/// 0.
struct AdamStep {
  float first, second;  ///< 1 / (1 - beta1^t) and 1 / sqrt(1 - beta2^t) of step t = 1, 2, ...

  static AdamStep number(std::uint64_t t, double beta1 = kAdamBeta1, double beta2 = kAdamBeta2) {
    const auto power = static_cast<double>(t);
    return {static_cast<float>(1 / (1 - std::pow(beta1, power))),
            static_cast<float>(1 / std::sqrt(1 - std::pow(beta2, power)))};
  }
};

/// Adds to a sum of gradients. A gradient that is not finite adds nothing.
QS_HD void add_gradient(float gradient, float& sum) {
  if (gradient - gradient == 0.0f) sum += gradient;
}

/// Moves `value` and updates its moments `first` and `second`, which start at 0. `step` is
/// AdamStep::number(t) of the current step t >= 1. A gradient that is not finite counts as 0, so
/// that no value ever becomes NaN.
QS_HD void adam(const AdamRule& rule, const AdamStep& step, float rate, float gradient,
                float& value, float& first, float& second) {
  if (!(gradient - gradient == 0.0f)) gradient = 0.0f;
  first = rule.beta1 * first + rule.rest1 * gradient;
  second = rule.beta2 * second + rule.rest2 * gradient * gradient;
  const float size = std::sqrt(second) * step.second + rule.epsilon;
  const float move = rate * step.first * first / size;
  if (move - move == 0.0f) value = value - move;
}

/// Takes the step with the usual rule.
QS_HD void adam(const AdamStep& step, float rate, float gradient, float& value, float& first,
                float& second) {
  constexpr AdamRule kRule = AdamRule::of(kAdamBeta1, kAdamBeta2, kAdamEpsilon);
  adam(kRule, step, rate, gradient, value, first, second);
}

}  // namespace qs
