// SPDX-License-Identifier: MIT
//
// The gradient of one step of compositing (composite.h): from the colour of a pixel to the Gaussian
// that the pixel blended.
//
//     C = sum over i of c_i alpha_i T_i + T_end background
//     T_i = product over j < i of (1 - alpha_j)
//     alpha = min(0.99, opacity e^E)
//     E = -(a dx^2 + c dy^2) / 2 - b dx dy,  (dx, dy) = pixel - mean
//
// The clamp at 0.99 passes the gradient through, as in the published training code, unless the
// rules say otherwise. Gaussians that a pixel skips, or in front of which it stops, get no gradient
// from it. A colour is glm::vec3, or has as many channels as `Color`.
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/blend.h"
#include "raster/kernel/hd.h"

namespace qs {

/// Sums over the pixels of a Gaussian, with d = dL/dE of each pixel. The rest of the gradient is
/// linear in these sums.
template <class Real, class Color = glm::vec<3, Real>>
struct PixelSums {
  Real d = 0, dx = 0, dy = 0;      ///< sums of d, d dx, d dy
  Real dxx = 0, dxy = 0, dyy = 0;  ///< sums of d dx^2, d dx dy, d dy^2
  Color color{0};                  ///< sum of dL/dc

  QS_HD PixelSums& operator+=(const PixelSums& other) {
    d += other.d;
    dx += other.dx;
    dy += other.dy;
    dxx += other.dxx;
    dxy += other.dxy;
    dyy += other.dyy;
    color += other.color;
    return *this;
  }
};

/// The loss's derivatives by the values that pixels read of a Gaussian.
template <class Real, class Color = glm::vec<3, Real>>
struct SplatGradient {
  glm::vec<2, Real> mean_px{0};
  glm::vec<3, Real> conic{0};  ///< derivative by a, b, c
  Real opacity = 0;            ///< derivative by the opacity that is blended: with compensation
  Color color{0};
};

/// dL/dalpha. `alpha` is below 1. `transmittance` is the value in front of the Gaussian; `behind`
/// is the colour that the Gaussians behind it and the background add to the pixel; `d_pixel` is
/// dL/dC.
template <class Real, class Color>
QS_HD Real alpha_gradient(const Color& color, Real alpha, Real transmittance, const Color& behind,
                          const Color& d_pixel) {
  return dot(d_pixel, color * transmittance - behind / (1 - alpha));
}

/// A pixel that blended a Gaussian, in the step that blended it; see alpha_gradient().
template <class Real, class Color = glm::vec<3, Real>>
struct BlendedPixel {
  Real x, y;
  Real alpha;          ///< as composite() returned it
  Real transmittance;  ///< in front of the Gaussian
  Color behind, d_pixel;
};

/// The derivative by a Gaussian's mean on the image, from sums of d dx and d dy, see PixelSums.
template <class Real>
QS_HD glm::vec<2, Real> mean_gradient(const typename PixelMath<Real>::Splat& splat, Real dx,
                                      Real dy) {
  // log2_conic is (-a/2, -b, -c/2) / ln 2, so dE/dmean_x = a dx + b dy is -ln 2 (2 x dx + y dy).
  const Real scale = -static_cast<Real>(kLn2);
  return {scale * (2 * splat.log2_conic.x * dx + splat.log2_conic.y * dy),
          scale * (2 * splat.log2_conic.z * dy + splat.log2_conic.y * dx)};
}

/// Adds the contribution of a pixel to a Gaussian that it blended, with dL/dalpha. Returns its part
/// of the derivative by the mean.
template <class Real, class Color>
QS_HD glm::vec<2, Real> add_pixel(const typename PixelMath<Real>::Splat& splat,
                                  const BlendedPixel<Real, Color>& pixel, Real d_alpha,
                                  PixelSums<Real, Color>& sums,
                                  const PixelRules<Real>& rules = {}) {
  using Math = PixelMath<Real>;
  const Real alpha = pixel.alpha;
  const Real dx = pixel.x - splat.mean_px.x, dy = pixel.y - splat.mean_px.y;
  sums.color += alpha * pixel.transmittance * pixel.d_pixel;
  Real unclamped = alpha;
  if (!(alpha < rules.alpha_max))
    unclamped =
        rules.alpha_max_passes ? splat.opacity * Math::exp2(log2_falloff(splat, dx, dy)) : Real(0);
  const Real d = unclamped * d_alpha;
  sums.d += d;
  sums.dx += d * dx;
  sums.dy += d * dy;
  sums.dxx += d * dx * dx;
  sums.dxy += d * dx * dy;
  sums.dyy += d * dy * dy;
  return mean_gradient<Real>(splat, d * dx, d * dy);
}

/// Adds a pixel whose colour alone is in the loss, and a Gaussian with its colour.
template <class Real>
QS_HD glm::vec<2, Real> add_pixel(const typename PixelMath<Real>::Splat& splat,
                                  const BlendedPixel<Real>& pixel, PixelSums<Real>& sums) {
  const Real d_alpha =
      alpha_gradient(splat.color, pixel.alpha, pixel.transmittance, pixel.behind, pixel.d_pixel);
  return add_pixel<Real, glm::vec<3, Real>>(splat, pixel, d_alpha, sums);
}

/// The gradient of a Gaussian from the sums over all its pixels.
template <class Real, class Color>
QS_HD SplatGradient<Real, Color> splat_gradient(const typename PixelMath<Real>::Splat& splat,
                                                const PixelSums<Real, Color>& sums) {
  SplatGradient<Real, Color> result;
  result.mean_px = mean_gradient<Real>(splat, sums.dx, sums.dy);
  result.conic = {-sums.dxx / 2, -sums.dxy, -sums.dyy / 2};
  result.opacity = splat.opacity > 0 ? sums.d / splat.opacity : Real(0);
  result.color = sums.color;
  return result;
}

}  // namespace qs
