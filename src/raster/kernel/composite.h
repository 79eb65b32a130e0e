// SPDX-License-Identifier: MIT
//
// Composites one Gaussian onto one pixel: the scalar reference version of the blend stage, for code
// that explains an image (used pairs, what a mode drops, the Gaussians of a pixel). Backends blend
// many pixels at once; their alphas may differ in the last bit.
#pragma once

#include "raster/kernel/blend.h"

namespace qs {

/// Outcome for one pixel: `skips` if alpha is below 1/255, `blends`, or `stops` if blending would
/// push the transmittance below the rules' limit.
enum class Step { skips, blends, stops };

/// (x, y) is the pixel. `transmittance` is the value in front of the Gaussian; `blends` sets it to
/// the value behind it. `alpha` is set unless the outcome is `skips`. Real is float, or double to
/// check gradients.
template <class Real>
QS_HD Step composite(const typename PixelMath<Real>::Splat& splat, Real x, Real y,
                     Real& transmittance, Real& alpha, const PixelRules<Real>& rules = {}) {
  using Math = PixelMath<Real>;
  const Real power = log2_falloff(splat, x - splat.mean_px.x, y - splat.mean_px.y);
  if (!(power <= 0)) return Step::skips;
  alpha = alpha_of(splat, power, rules.alpha_max);
  if (!(alpha >= Math::kAlphaMin)) return Step::skips;
  const Real next = transmittance * (1 - alpha);
  if (next < rules.stops_below) return Step::stops;
  transmittance = next;
  return Step::blends;
}

}  // namespace qs
