// SPDX-License-Identifier: MIT
//
// The gradient of one step of compositing (composite.h): from the colour of a pixel to the Gaussian
// that the pixel blended.
//   C = sum over i of c_i alpha_i T_i + T_end background,   T_i = product over j < i of (1 -
//   alpha_j) alpha = min(0.99, opacity e^E),   E = -(a dx^2 + c dy^2) / 2 - b dx dy,   (dx, dy) =
//   pixel - mean
// The clamp at 0.99 passes the gradient through, as in the published training code. Gaussians that
// a pixel skips, or in front of which it stops, get no gradient from it.
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/hd.h"
#include "raster/kernel/splat64.h"

namespace qs {

/// The loss's derivatives by the values that pixels read of a Gaussian.
template <class Real>
struct SplatGradient {
  glm::vec<2, Real> mean_px{0};
  glm::vec<3, Real> conic{0};  ///< by a, b, c
  Real opacity = 0;            ///< by the opacity that is blended: with compensation
  glm::vec<3, Real> color{0};

  QS_HD SplatGradient& operator+=(const SplatGradient& other) {
    mean_px += other.mean_px;
    conic += other.conic;
    opacity += other.opacity;
    color += other.color;
    return *this;
  }
};

/// dL/dalpha. `transmittance` is the value in front of the Gaussian; `behind` is the colour that
/// the Gaussians behind it and the background add to the pixel; `d_pixel` is dL/dC.
template <class Real>
QS_HD Real alpha_gradient(const glm::vec<3, Real>& color, Real alpha, Real transmittance,
                          const glm::vec<3, Real>& behind, const glm::vec<3, Real>& d_pixel) {
  return glm::dot(d_pixel, color * transmittance - behind / (1 - alpha));
}

/// Adds the gradient that pixel (x, y) gives to a Gaussian that it blended. `alpha` is as
/// composite() returned it; the other arguments are those of alpha_gradient().
template <class Real>
QS_HD void add_pixel_gradient(const typename PixelMath<Real>::Splat& splat, Real x, Real y,
                              Real alpha, Real transmittance, const glm::vec<3, Real>& behind,
                              const glm::vec<3, Real>& d_pixel, SplatGradient<Real>& sum) {
  using Math = PixelMath<Real>;
  const Real dx = x - splat.mean_px.x, dy = y - splat.mean_px.y;
  sum.color += alpha * transmittance * d_pixel;
  const Real d_alpha = alpha_gradient(splat.color, alpha, transmittance, behind, d_pixel);
  const Real unclamped =
      alpha < Math::kAlphaMax ? alpha : splat.opacity * Math::exp2(log2_falloff(splat, dx, dy));
  sum.opacity += d_alpha * unclamped / splat.opacity;
  const Real d_exponent = d_alpha * unclamped;  // by E
  sum.conic.x -= d_exponent * dx * dx / 2;
  sum.conic.y -= d_exponent * dx * dy;
  sum.conic.z -= d_exponent * dy * dy / 2;
  // log2_conic is (-a/2, -b, -c/2) / ln 2, so dE/dmean_x = a dx + b dy is -ln 2 (2 x dx + y dy).
  const Real scaled = -static_cast<Real>(kLn2) * d_exponent;
  sum.mean_px.x += scaled * (2 * splat.log2_conic.x * dx + splat.log2_conic.y * dy);
  sum.mean_px.y += scaled * (2 * splat.log2_conic.z * dy + splat.log2_conic.y * dx);
}

}  // namespace qs
