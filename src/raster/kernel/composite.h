// SPDX-License-Identifier: MIT
//
// One step of a pixel through its tile's list, one Gaussian at a time: what blending does, without
// the shape that makes it fast. Whatever explains a picture (which pairs were used, what a mode
// drops, the Gaussians of a pixel) walks pixels with this; backends blend many pixels at once and
// come to the same decisions but for the last bit of an alpha.
#pragma once

#include "raster/kernel/blend.h"

namespace qs {

/// What a Gaussian does to a pixel: too little to count, it is blended, or it would bring the
/// transmittance below kTransmittanceMin, so that the pixel stops in front of it.
enum class Step { skips, blends, stops };

/// `transmittance` is that in front of the Gaussian, and behind it afterwards if it blends. `alpha`
/// is set unless it skips.
QS_HD Step composite(const Splat& splat, float x, float y, float& transmittance, float& alpha) {
  const float power = log2_falloff(splat, x - splat.mean_px.x, y - splat.mean_px.y);
  if (!(power <= 0.0f)) return Step::skips;
  alpha = alpha_of(splat, power);
  if (!(alpha >= kAlphaMin)) return Step::skips;
  const float next = transmittance * (1.0f - alpha);
  if (next < kTransmittanceMin) return Step::stops;
  transmittance = next;
  return Step::blends;
}

}  // namespace qs
