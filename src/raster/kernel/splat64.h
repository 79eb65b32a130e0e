// SPDX-License-Identifier: MIT
//
// The counterpart of blend.h in double precision: the input of a pixel and its alpha. Training uses
// it to check gradients; templates choose by the type of their arguments.
#pragma once

#include <cmath>
#include <type_traits>

#include "raster/kernel/blend.h"

namespace qs {

/// See Splat.
struct Splat64 {
  glm::dvec2 mean_px;
  glm::dvec3 log2_conic;
  double opacity;
  glm::dvec3 color;
};

QS_HD double log2_falloff(const Splat64& splat, double dx, double dy) {
  return splat.log2_conic.x * dx * dx + splat.log2_conic.z * dy * dy + splat.log2_conic.y * dx * dy;
}

QS_HD Splat64 make_splat(glm::dvec2 mean_px, glm::dvec3 conic, double opacity, glm::dvec3 color) {
  constexpr double kLog2OfFalloff64 = -0.5 * kLog2E;
  return {mean_px, kLog2OfFalloff64 * glm::dvec3(conic.x, 2 * conic.y, conic.z), opacity, color};
}

QS_HD double alpha_of(const Splat64& splat, double power, double alpha_max = fp64::kAlphaMax) {
  const double alpha = splat.opacity * std::exp2(power);
  return alpha < alpha_max ? alpha : alpha_max;
}

/// The precision of a pixel: its input, its exponential and the thresholds of compositing.
template <class Real>
struct PixelMath;

template <>
struct PixelMath<float> {
  using Splat = qs::Splat;
  static constexpr float kAlphaMin = qs::kAlphaMin, kAlphaMax = qs::kAlphaMax,
                         kTransmittanceMin = qs::kTransmittanceMin;
  static QS_HD float exp2(float x) { return exp2_polynomial(x); }
};

template <>
struct PixelMath<double> {
  using Splat = qs::Splat64;
  static constexpr double kAlphaMin = fp64::kAlphaMin, kAlphaMax = fp64::kAlphaMax,
                          kTransmittanceMin = fp64::kTransmittanceMin;
  static QS_HD double exp2(double x) { return std::exp2(x); }
};

/// The rules of compositing in which rasterizers differ. The defaults are the rules of 3DGS.
template <class Real>
struct PixelRules {
  Real alpha_max = PixelMath<Real>::kAlphaMax;  ///< alpha is clamped to this
  bool alpha_max_passes = true;                 ///< a clamped alpha passes its gradient on
  /// A pixel stops in front of a Gaussian that would push its transmittance below this.
  Real stops_below = PixelMath<Real>::kTransmittanceMin;

  bool are_default() const {
    const PixelRules defaults;
    return alpha_max == defaults.alpha_max && stops_below == defaults.stops_below &&
           alpha_max_passes == defaults.alpha_max_passes;
  }
};

}  // namespace qs
