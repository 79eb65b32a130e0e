// SPDX-License-Identifier: MIT
//
// The gradient of a Gaussian in a view, from its splat (the values that pixels read) to its
// parameters, through all steps of the projection and of the colour.
#pragma once

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/activation.h"
#include "raster/kernel/gradient/activation.h"
#include "raster/kernel/gradient/footprint.h"
#include "raster/kernel/gradient/mask.h"
#include "raster/kernel/gradient/pixel.h"
#include "raster/kernel/gradient/project.h"
#include "raster/kernel/gradient/sh.h"
#include "raster/kernel/hd.h"
#include "raster/kernel/sh.h"

namespace qs {

/// A Gaussian's covariance on the image in px^2.
template <class Real>
struct ImageCovariance {
  Covariance2<Real> before, after;  ///< without and with the dilation

  static QS_HD ImageCovariance of(const View<Real>& view, const glm::vec<3, Real>& point,
                                  const Covariance3<Real>& sigma, double dilation) {
    const Covariance2<Real> c = project_covariance(view, point, sigma);
    return {c, {c.xx + static_cast<Real>(dilation), c.xy, c.yy + static_cast<Real>(dilation)}};
  }
};

/// The parameters of a Gaussian without its colour's, or the derivatives by them.
template <class Real>
struct GaussianValues {
  glm::vec<3, Real> mean, log_scale;
  glm::qua<Real> rotation;  ///< of any length above 0, normalised when used
  Real opacity_logit;
  Real mask_logit{kFirstMaskLogit};  ///< see kernel/gradient/mask.h
};

/// The values that the gradients of all Gaussians in a view share.
template <class Real>
struct GradientRules {
  View<Real> view;
  double dilation;
  bool antialiased;
  int sh_degree;
};

/// The derivatives by the coefficients of colour follow from these, see sh_gradient().
template <class Real>
struct ColorGradient {
  glm::vec<3, Real> direction;  ///< from the camera to the Gaussian, unit
  glm::vec<3, Real> by_color;   ///< before the clamp

  /// `d_color` is the derivative by the colour that pixels read. `coefficients` is as for
  /// sh_color().
  template <class Coefficients>
  static QS_HD ColorGradient of(const GradientRules<Real>& rules, const glm::vec<3, Real>& mean,
                                const Coefficients& coefficients,
                                const glm::vec<3, Real>& d_color) {
    const glm::vec<3, Real> direction = glm::normalize(mean - rules.view.position);
    const glm::vec<3, Real> color = sh_color<Real>(rules.sh_degree, direction, coefficients);
    return {direction, clamp_gradient(color, d_color)};
  }
};

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
  const Vec3 point = to_view(view, gaussian.mean);
  const auto covariance = ImageCovariance<Real>::of(view, point, sigma, rules.dilation);

  const Real opacity = opacity_of(gaussian.opacity_logit);
  Real d_opacity = splat.opacity;
  Covariance2<Real> d_covariance = conic_gradient(covariance.after, splat.conic);
  if (rules.antialiased) {
    const Real factor =
        compensation(covariance.before.determinant(), covariance.after.determinant());
    const Covariance2<Real> more =
        compensation_gradient(covariance.before, covariance.after, splat.opacity * opacity);
    d_covariance.xx += more.xx;
    d_covariance.xy += more.xy;
    d_covariance.yy += more.yy;
    d_opacity *= factor;
  }

  const GeometryGradient<Real> geometry =
      project_covariance_gradient(view, point, sigma, d_covariance);
  const ShapeGradient<Real> shape =
      covariance_gradient(gaussian.log_scale, gaussian.rotation, geometry.covariance);
  const Vec3 d_mean =
      view_gradient(view, geometry.mean + pixel_gradient(view, point, splat.mean_px));

  const Vec3 offset = gaussian.mean - view.position;
  const Vec3 d_direction =
      sh_gradient(rules.sh_degree, color.direction, coefficients, color.by_color, add);
  return {
      d_mean + direction_gradient(offset, d_direction), shape.log_scale, shape.rotation,
      opacity_gradient(opacity, d_opacity),
      mask_gradient(gaussian.mask_logit, shape.log_scale.x + shape.log_scale.y + shape.log_scale.z,
                    opacity * d_opacity)};
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
