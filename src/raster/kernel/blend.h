// SPDX-License-Identifier: MIT
//
// Alpha of one Gaussian at one pixel. Branch-free, so that compilers vectorise a row of pixels.
#pragma once

#include <cstdint>
#include <cstring>

#include <glm/vec3.hpp>

#include "raster/kernel/constants.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/hd.h"

namespace qs {

/// A visible Gaussian: the input of the blend stage.
struct Splat {
  glm::vec2 mean_px;
  /// log2 of the falloff is x dx^2 + y dx dy + z dy^2: (-a/2, -b, -c/2) log2(e) of the conic.
  glm::vec3 log2_conic;
  float opacity;
  glm::vec3 color;  ///< RGB >= 0
};

/// `conic` is (a, b, c) of a footprint.
QS_HD Splat make_splat(glm::vec2 mean_px, glm::vec3 conic, float opacity, glm::vec3 color) {
  return {
      mean_px,
      glm::vec3(kLog2OfFalloff * conic.x, 2 * kLog2OfFalloff * conic.y, kLog2OfFalloff * conic.z),
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
  std::uint32_t bits, exponent;  // unsigned: x far above the range wraps instead of being undefined
  std::memcpy(&bits, &p, sizeof bits);
  std::memcpy(&exponent, &shifted, sizeof exponent);
  bits += exponent << 23;
  std::memcpy(&p, &bits, sizeof p);
  return p;
}

/// log2 of the falloff at the offset (dx, dy) from the mean, pixels. It is > 0 only if rounding
/// broke the conic; such pixels are skipped.
QS_HD float log2_falloff(const Splat& splat, float dx, float dy) {
  return splat.log2_conic.x * dx * dx + splat.log2_conic.z * dy * dy + splat.log2_conic.y * dx * dy;
}

/// min(alpha_max, opacity * 2^power). `power` is log2_falloff().
QS_HD float alpha_of(const Splat& splat, float power, float alpha_max = kAlphaMax) {
  const float alpha = splat.opacity * exp2_polynomial(power);
  return alpha < alpha_max ? alpha : alpha_max;
}

}  // namespace qs
