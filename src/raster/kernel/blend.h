// SPDX-License-Identifier: MIT
//
// Alpha of one Gaussian at one pixel. Branch-free, so that compilers vectorise a row of pixels.
// Real is float, or double where training checks gradients.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/constants.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/hd.h"

namespace qs {

/// A visible Gaussian: the input of the blend stage.
template <class Real>
struct SplatOf {
  glm::vec<2, Real> mean_px;
  /// log2 of the falloff is x dx^2 + y dx dy + z dy^2: (-a/2, -b, -c/2) log2(e) of the conic.
  glm::vec<3, Real> log2_conic;
  Real opacity;
  glm::vec<3, Real> color;  ///< RGB >= 0
};
using Splat = SplatOf<float>;

/// `conic` is (a, b, c) of a footprint.
template <class Real>
QS_HD SplatOf<Real> make_splat(const glm::vec<2, Real>& mean_px, const glm::vec<3, Real>& conic,
                               Real opacity, const glm::vec<3, Real>& color) {
  constexpr Real kScale = Real(-0.5) * Real(kLog2E);  // kLog2OfFalloff
  return {mean_px, glm::vec<3, Real>(kScale * conic.x, 2 * kScale * conic.y, kScale * conic.z),
          opacity, color};
}

QS_HD Splat make_splat(const Footprint& footprint, float opacity, glm::vec3 color) {
  return make_splat(footprint.mean_px, footprint.conic, opacity, color);
}

/// 2^x, relative error below 2e-7 for -126 <= x < 127; smaller x give 2^-126.
QS_HD float exp2_polynomial(float x) {
  x = x > -126.0f ? x : -126.0f;
  const float shifted = x + kRoundToInteger;
  const float fraction = x - (shifted - kRoundToInteger);
  float p = kExp2C5;
  p = p * fraction + kExp2C4;
  p = p * fraction + kExp2C3;
  p = p * fraction + kExp2C2;
  p = p * fraction + kExp2C1;
  p = p * fraction + 1.0f;
  // Unsigned: x far above the range wraps instead of being undefined.
  const auto exponent = std::bit_cast<std::uint32_t>(shifted);
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(p) + (exponent << 23));
}

/// The precision of a pixel: its input, its exponential and the thresholds of compositing.
template <class Real>
struct PixelMath {
  using Splat = SplatOf<Real>;
  static constexpr auto kAlphaMin = static_cast<Real>(fp64::kAlphaMin);
  static constexpr auto kAlphaMax = static_cast<Real>(fp64::kAlphaMax);
  static constexpr auto kTransmittanceMin = static_cast<Real>(fp64::kTransmittanceMin);

  static QS_HD Real exp2(Real x) {
    if constexpr (std::is_same_v<Real, float>)
      return exp2_polynomial(x);
    else
      return std::exp2(x);
  }
};

/// log2 of the falloff at the offset (dx, dy) from the mean, pixels. It is > 0 only if rounding
/// broke the conic; such pixels are skipped.
template <class Real>
QS_HD Real log2_falloff(const SplatOf<Real>& splat, Real dx, Real dy) {
  return splat.log2_conic.x * dx * dx + splat.log2_conic.z * dy * dy + splat.log2_conic.y * dx * dy;
}

/// min(alpha_max, opacity * 2^power). `power` is log2_falloff().
template <class Real>
QS_HD Real alpha_of(const SplatOf<Real>& splat, Real power,
                    Real alpha_max = PixelMath<Real>::kAlphaMax) {
  const Real alpha = splat.opacity * PixelMath<Real>::exp2(power);
  return alpha < alpha_max ? alpha : alpha_max;
}

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
