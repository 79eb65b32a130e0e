// SPDX-License-Identifier: MIT
//
// The gradient of a Gaussian in a view, from its splat (the values that pixels read) to its
// parameters, through all steps of the projection and of the colour.
#pragma once

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "learn/gradient/activation.h"
#include "learn/gradient/mask.h"
#include "learn/gradient/pixel.h"
#include "learn/gradient/project.h"
#include "learn/gradient/sh.h"
#include "raster/kernel/activation.h"
#include "raster/kernel/hd.h"
#include "raster/kernel/sh.h"

namespace qs {

/// A Gaussian's covariance on the image in px^2.
template <class Real>
struct ImageCovariance {
  Covariance2<Real> before, after;  ///< without and with the dilation

  /// `Rules` has the members of GradientRules.
  template <class Rules>
  static QS_HD ImageCovariance of(const Rules& rules, const glm::vec<3, Real>& point,
                                  const Covariance3<Real>& sigma) {
    const SlopeLimits<Real> limits = rules.slope_limits(rules.view);
    Covariance2<Real> c = project_covariance(rules.view, limits, point, sigma);
    const Real scale2 = Real{rules.splat_scale} * Real{rules.splat_scale};
    c = {c.xx * scale2, c.xy * scale2, c.yy * scale2};
    ImageCovariance result{c, c};
    dilate(rules.view, limits, point, static_cast<Real>(rules.dilation), result.after);
    return result;
  }
};

/// The parameters of a Gaussian without its colour's, or the derivatives by them.
template <class Real>
struct GaussianValues {
  glm::vec<3, Real> mean, log_scale;
  glm::qua<Real> rotation;  ///< quaternion of any length above 0, normalised when used
  Real opacity_logit;
  Real mask_logit{kFirstMaskLogit};  ///< see learn/gradient/mask.h

  static QS_HD GaussianValues zero() {
    return {glm::vec<3, Real>(0), glm::vec<3, Real>(0), glm::qua<Real>(0, 0, 0, 0), 0, 0};
  }
};

/// The values that the gradients of all Gaussians in a view share.
template <class Real>
struct GradientRules {
  View<Real> view;
  double dilation;
  bool antialiased;
  int sh_degree;

  // The rules that training does not change.
  static constexpr Real splat_scale = 1;
  static constexpr Real compensation_floor = static_cast<Real>(kCompensationFloor);
  static constexpr bool zero_color_passes = false;  ///< see clamp_gradient()
  static QS_HD SlopeLimits<Real> slope_limits(const View<Real>& view) {
    return SlopeLimits<Real>::of(view);
  }
};

/// The derivatives by the coefficients of colour follow from these, see sh_gradient().
template <class Real>
struct ColorGradient {
  glm::vec<3, Real> direction;  ///< from the camera to the Gaussian, unit
  glm::vec<3, Real> by_color;   ///< before the clamp

  /// `d_color` is the derivative by the colour that pixels read. `coefficients` is as for
  /// sh_color(). `Rules` has the members of GradientRules.
  template <class Rules, class Coefficients>
  static QS_HD ColorGradient of(const Rules& rules, const glm::vec<3, Real>& mean,
                                const Coefficients& coefficients,
                                const glm::vec<3, Real>& d_color) {
    const glm::vec<3, Real> direction = glm::normalize(mean - rules.view.position);
    const glm::vec<3, Real> color =
        unclamped_sh_color<Real>(rules.sh_degree, direction, coefficients);
    return {direction, clamp_gradient(color, d_color, rules.zero_color_passes)};
  }
};

/// Derivatives by a Gaussian's place and shape in a view and by its opacity without compensation.
template <class Real>
struct PlacedGradient {
  GeometryGradient<Real> geometry;  ///< derivative by the point in view axes
  Real opacity;
};

/// Passes derivatives on from the values that pixels read of a Gaussian to its place. `point` is
/// its mean in view axes; the colour of `splat` is not read. `Rules` has the members of
/// GradientRules.
template <class Real, class Rules>
QS_HD PlacedGradient<Real> placed_gradient(const Rules& rules, const glm::vec<3, Real>& point,
                                           const Covariance3<Real>& sigma, Real opacity,
                                           const SplatGradient<Real>& splat) {
  const View<Real>& view = rules.view;
  const auto covariance = ImageCovariance<Real>::of(rules, point, sigma);
  Real d_opacity = splat.opacity;
  Covariance2<Real> d_after = conic_gradient(covariance.after, splat.conic), d_before{0, 0, 0};
  if (rules.antialiased) {
    const Real floor = rules.compensation_floor;
    d_opacity *=
        compensation(covariance.before.determinant(), covariance.after.determinant(), floor);
    add_compensation_gradient(covariance.before, covariance.after, splat.opacity * opacity,
                              d_before, d_after, floor);
  }
  const Real scale2 = Real{rules.splat_scale} * Real{rules.splat_scale};
  d_before = {(d_before.xx + d_after.xx) * scale2, (d_before.xy + d_after.xy) * scale2,
              (d_before.yy + d_after.yy) * scale2};
  const SlopeLimits<Real> limits = rules.slope_limits(view);
  PlacedGradient<Real> result{project_covariance_gradient(view, limits, point, sigma, d_before),
                              d_opacity};
  add_dilation_gradient(view, limits, point, static_cast<Real>(rules.dilation), d_after,
                        result.geometry.mean);
  result.geometry.mean += pixel_gradient(view, point, splat.mean_px);
  return result;
}

/// `splat` holds the derivatives by the values that pixels read, `color` is made of them.
/// `coefficients` is as for sh_color(). Calls add(k, gradient) for every RGB coefficient of the
/// degree.
template <class Real, class Coefficients, class Add>
QS_HD GaussianValues<Real> gaussian_gradient(const GradientRules<Real>& rules,
                                             const GaussianValues<Real>& gaussian,
                                             const Coefficients& coefficients,
                                             const SplatGradient<Real>& splat,
                                             const ColorGradient<Real>& color, const Add& add) {
  using Vec3 = glm::vec<3, Real>;
  const View<Real>& view = rules.view;
  const Covariance3<Real> sigma =
      covariance_of(gaussian.log_scale, unit_rotation(gaussian.rotation));
  const Real opacity = opacity_of(gaussian.opacity_logit);
  const PlacedGradient<Real> placed =
      placed_gradient(rules, to_view(view, gaussian.mean), sigma, opacity, splat);
  const ShapeGradient<Real> shape =
      covariance_gradient(gaussian.log_scale, gaussian.rotation, placed.geometry.covariance);
  const Vec3 d_mean = view_gradient(view, placed.geometry.mean);

  const Vec3 offset = gaussian.mean - view.position;
  const Vec3 d_direction =
      sh_gradient(rules.sh_degree, color.direction, coefficients, color.by_color, add);
  return {
      d_mean + direction_gradient(offset, d_direction), shape.log_scale, shape.rotation,
      opacity_gradient(opacity, placed.opacity),
      mask_gradient(gaussian.mask_logit, shape.log_scale.x + shape.log_scale.y + shape.log_scale.z,
                    opacity * placed.opacity)};
}

template <class Real, class Coefficients, class Add>
QS_HD GaussianValues<Real> gaussian_gradient(const GradientRules<Real>& rules,
                                             const GaussianValues<Real>& gaussian,
                                             const Coefficients& coefficients,
                                             const SplatGradient<Real>& splat, const Add& add) {
  const auto color = ColorGradient<Real>::of(rules, gaussian.mean, coefficients, splat.color);
  return gaussian_gradient(rules, gaussian, coefficients, splat, color, add);
}

}  // namespace qs
