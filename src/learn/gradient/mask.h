// SPDX-License-Identifier: MIT
//
// A mask that is trained per Gaussian (Compact 3D Gaussian Representation, Lee et al., CVPR 2024,
// arXiv 2311.13681, equations 1 to 4). A Gaussian exists only while the sigmoid of its logit is
// above a threshold: otherwise its scales and opacity count as 0. The threshold has no derivative,
// so the derivative of the sigmoid replaces it (straight through).
#pragma once

#include "learn/gradient/activation.h"
#include "raster/kernel/activation.h"
#include "raster/kernel/hd.h"

namespace qs {

inline constexpr float kFirstMaskLogit = 1;
/// ln(0.01 / 0.99): the sigmoid of greater logits is above 0.01.
inline constexpr float kMaskedOutLogit = -4.59511985f;

/// True if the Gaussian is masked out.
QS_HD bool masked_out(double mask_logit) { return !(mask_logit > double{kMaskedOutLogit}); }

/// The derivative by the logit of a Gaussian that exists: scales and opacity are products with the
/// mask. `by_log_scales` is the sum over the axes, `by_log_opacity` the derivative by ln(opacity).
template <class Real>
QS_HD Real mask_gradient(Real mask_logit, Real by_log_scales, Real by_log_opacity) {
  return opacity_gradient(opacity_of(mask_logit), by_log_scales + by_log_opacity);
}

/// The derivative of weight * mean(sigmoid) by the logit of one of `count` > 0 Gaussians.
QS_HD float mask_weight_gradient(double weight, double count, float mask_logit) {
  const double mask = opacity_of(static_cast<double>(mask_logit));
  return static_cast<float>(opacity_gradient(mask, weight / count));
}

}  // namespace qs
