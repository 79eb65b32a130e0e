// SPDX-License-Identifier: MIT
//
// The mathematics of project() and of its backward pass for one Gaussian in the caller's arrays.
// Every backend calls it, with pointers that it can read.
#pragma once

#include <type_traits>

#include <glm/geometric.hpp>

#include "learn/diff/gaussians.h"
#include "learn/diff/rules.h"
#include "learn/gradient/gaussian.h"
#include "learn/gradient/sh.h"
#include "raster/kernel/activation.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/hd.h"
#include "raster/kernel/sh.h"

namespace qs::diff {

/// The values that pixels read of a Gaussian, without its colour.
template <class Real>
struct SplatValues {
  glm::vec<2, Real> mean_px;
  glm::vec<3, Real> conic;
  Real depth, opacity;

  /// `projected` is the Gaussian's footprint in single precision; in double precision the values
  /// are computed again. `Rules` has the members of GradientRules.
  template <class Rules>
  static QS_HD SplatValues of(const Rules& rules, const glm::vec<3, Real>& mean,
                              const Covariance3<double>& sigma, double opacity,
                              const Projected& projected) {
    if constexpr (std::is_same_v<Real, float>) {
      return {projected.footprint.mean_px, projected.footprint.conic, projected.depth,
              static_cast<float>(opacity) * projected.opacity_factor};
    } else {
      const glm::dvec3 point = to_view(rules.view, mean);
      const auto covariance = ImageCovariance<double>::of(rules, point, sigma);
      const Covariance2<double>& c = covariance.after;
      const double determinant = c.determinant();
      if (rules.antialiased)
        opacity *= compensation(covariance.before.determinant(), determinant,
                                double{rules.compensation_floor});
      return {to_pixel(rules.view, point), glm::dvec3(c.yy, -c.xy, c.xx) / determinant, point.z,
              opacity};
    }
  }
};

QS_HD bool finite(double value) { return value - value == 0; }

template <class Real>
QS_HD bool finite(const Rows<const Real>& rows, std::size_t i, int numbers) {
  bool all = true;
  for (int k = 0; k < numbers && rows; ++k) all = all && finite(static_cast<double>(rows.at(i, k)));
  return all;
}

template <class T>
QS_HD Covariance3<T> covariance_at(const auto& rows, std::size_t i) {
  const auto at = [&](int k) { return static_cast<T>(rows.at(i, k)); };
  return {at(0), at(1), at(2), at(3), at(4), at(5)};
}

/// The coefficients of colour of a Gaussian in the caller's arrays, and their derivatives.
template <class Real>
struct CallersSh {
  ShRows<const Real> in;
  ShRows<Real> out;
  std::size_t i;

  QS_HD glm::vec<3, Real> operator()(int k) const { return in.vec3(i, k); }
  QS_HD void set(int k, const glm::vec<3, Real>& value) const { out.set(i, k, value); }
};

/// Gaussians in the caller's arrays, as a source of project_gaussians() of the CPU's passes, and
/// the arrays that project() fills.
template <class Real>
struct GivenGaussians {
  static constexpr bool kReports = true;

  PassRules<Real> rules;
  GaussianInputs<Real> in;
  Boundary<Real> out;
  Rows<std::int32_t> radii;  ///< 2

  /// Sets the rows of a Gaussian to 0.
  QS_HD void clear(std::size_t i) const {
    out.clear(i);
    radii.fill(i, 2, 0);
  }

  /// In the caller's arrays. Elsewhere copies of them may be read, with sh(k) for coefficient k.
  QS_HD CallersSh<Real> sh(std::size_t i) const { return {in.sh, {}, i}; }

  QS_HD bool exists(std::size_t i) const { return has_finite_shape(i) && has_finite_color(sh(i)); }
  QS_HD bool has_finite_shape(std::size_t i) const {
    return finite(in.means, i, 3) && finite(in.scales, i, 3) && finite(in.rotations, i, 4) &&
           finite(in.covariances, i, 6) && finite(in.opacities, i, 1) &&
           finite(in.channels, i, in.channel_count);
  }
  QS_HD bool has_finite_color(const auto& sh) const {
    bool all = true;
    const int coefficients = in.sh ? sh_coefficient_count(rules.sh_degree) : 0;
    for (int k = 0; k < coefficients; ++k) {
      const glm::vec<3, Real> values = sh(k);
      for (int c = 0; c < 3; ++c) all = all && finite(static_cast<double>(values[c]));
    }
    return all;
  }
  QS_HD glm::vec<3, Real> mean(std::size_t i) const { return in.means.vec3(i); }
  QS_HD double opacity(std::size_t i) const { return static_cast<double>(in.opacities.at(i)); }
  QS_HD Covariance3<double> covariance(std::size_t i) const {
    if (in.covariances) return covariance_at<double>(in.covariances, i);
    const glm::dquat rotation(in.rotations.quaternion(i));
    return scaled_covariance(glm::dvec3(in.scales.vec3(i)),
                             rules.normalises_rotations ? unit_rotation(rotation) : rotation);
  }
  QS_HD glm::vec<3, Real> color(std::size_t i, const glm::vec<3, Real>& mean) const {
    return color(mean, sh(i));
  }
  QS_HD glm::vec<3, Real> color(const glm::vec<3, Real>& mean, const auto& sh) const {
    if (!in.sh) return glm::vec<3, Real>(0);
    return sh_color<Real>(rules.sh_degree, glm::normalize(mean - rules.view.position), sh);
  }

  QS_HD bool report(std::size_t i, const Projected& projected, const SplatValues<Real>& values,
                    const glm::vec<3, Real>& color) const {
    if (!finite(static_cast<double>(color.x + color.y + color.z))) return false;
    auto mean_px = values.mean_px;
    if (radii || rules.radius_clip > 0 || out.mean_offset != 0) {
      const glm::ivec2 found =
          radii_of(rules.radius_rule, projected.footprint, static_cast<float>(values.opacity),
                   rules.width, rules.height);
      const double clip = rules.radius_clip;
      if (clip > 0 && found.x <= clip && found.y <= clip) return false;
      radii.set(i, found);
      if (out.mean_offset != 0)
        mean_px = found.x > 0 && found.y > 0 ? mean_px + out.mean_offset : decltype(mean_px)(0);
    }
    out.mean_px.set(i, mean_px);
    out.conic.set(i, values.conic);
    out.depth.set(i, values.depth);
    out.opacity.set(i, values.opacity);
    out.color.set(i, color);
    return true;
  }
};

/// The derivatives by the boundary of one Gaussian.
template <class Real>
struct BoundaryGradient {
  SplatGradient<Real> splat;
  Real depth{0};

  /// Reads Gaussian i's derivatives; a missing row counts as 0.
  static QS_HD BoundaryGradient of(const Boundary<const Real>& by, std::size_t i) {
    BoundaryGradient d;
    if (by.mean_px) d.splat.mean_px = by.mean_px.vec2(i);
    if (by.conic) d.splat.conic = by.conic.vec3(i);
    if (by.opacity) d.splat.opacity = by.opacity.at(i);
    if (by.color) d.splat.color = by.color.vec3(i);
    if (by.depth) d.depth = by.depth.at(i);
    return d;
  }
  QS_HD bool is_zero() const {
    return splat.mean_px == glm::vec<2, Real>(0) && splat.conic == glm::vec<3, Real>(0) &&
           splat.opacity == 0 && splat.color == glm::vec<3, Real>(0) && depth == 0;
  }
};

/// The gradient of one Gaussian in the caller's arrays.
template <class Real>
struct GivenGradient {
  using Vec3 = glm::vec<3, Real>;

  PassRules<Real> rules;
  GaussianInputs<Real> in;
  InputGradients<Real> out;

  /// Inputs that are not given have no derivatives.
  GivenGradient(const PassRules<Real>& of_view, const GaussianInputs<Real>& inputs,
                const InputGradients<Real>& wanted)
      : rules(of_view), in(inputs), out(wanted) {
    if (in.covariances)
      out.scales = out.rotations = {};
    else
      out.covariances = {};
    if (!in.sh) out.sh = {};
  }

  /// In the caller's arrays. Elsewhere copies of them may take their place, with sh(k) for
  /// coefficient k and sh.set(k, value) for its derivative.
  QS_HD CallersSh<Real> sh(std::size_t i) const { return {in.sh, out.sh, i}; }

  /// Sets the rows of a Gaussian to 0.
  QS_HD void clear(std::size_t i) const { clear(i, sh(i)); }
  QS_HD void clear(std::size_t i, const auto& sh) const {
    out.means.fill(i, 3, 0);
    out.scales.fill(i, 3, 0);
    out.rotations.fill(i, 4, 0);
    out.covariances.fill(i, 6, 0);
    out.opacities.fill(i, 1, 0);
    clear_coefficients(sh, 0);
  }
  /// Sets the coefficients from `first` on to 0.
  QS_HD void clear_coefficients(const auto& sh, int first) const {
    const int end = out.sh ? sh_coefficient_count(in.sh_degree) : 0;
    for (int k = first; k < end; ++k) sh.set(k, Vec3(0));
  }

  /// Returns the derivative by the mean through the colour's direction.
  QS_HD Vec3 color(const Vec3& mean, const Vec3& d_color, const auto& sh) const {
    clear_coefficients(sh, sh_coefficient_count(rules.sh_degree));
    if (!in.sh) return Vec3(0);
    const auto gradient = ColorGradient<Real>::of(rules, mean, sh, d_color);
    const Vec3 d_direction = sh_gradient<Real>(rules.sh_degree, gradient.direction, sh,
                                               gradient.by_color, [&](int k, const Vec3& value) {
                                                 if (out.sh) sh.set(k, value);
                                               });
    return direction_gradient(mean - rules.view.position, d_direction);
  }

  /// Writes the rows of a Gaussian that has a row in the boundary, and adds to `pose` if `kPose`.
  /// If `by` is zero, clear() takes the place of add().
  template <bool kPose = true>
  QS_HD void add(std::size_t i, const BoundaryGradient<Real>& by, PoseGradient& pose) const {
    add<kPose>(i, by, pose, sh(i));
  }
  template <bool kPose>
  QS_HD void add(std::size_t i, const BoundaryGradient<Real>& by, PoseGradient& pose,
                 const auto& sh) const {
    const SplatGradient<Real>& d = by.splat;
    const Vec3 mean = in.means.vec3(i);
    Vec3 scale(0);
    glm::qua<Real> rotation(1, 0, 0, 0), q = rotation;
    Covariance3<Real> sigma;
    if (in.covariances) {
      sigma = covariance_at<Real>(in.covariances, i);
    } else {
      scale = in.scales.vec3(i);
      rotation = in.rotations.quaternion(i);
      q = rules.normalises_rotations ? unit_rotation(rotation) : rotation;
      sigma = scaled_covariance(scale, q);
    }
    PlacedGradient<Real> placed =
        placed_gradient(rules, to_view(rules.view, mean), sigma, in.opacities.at(i), d);
    placed.geometry.mean.z += by.depth;
    const Vec3 by_direction = color(mean, d.color, sh);

    out.means.set(i, view_gradient(rules.view, placed.geometry.mean) + by_direction);
    out.opacities.set(i, placed.opacity);
    const Covariance3<Real>& c = placed.geometry.covariance;
    if (in.covariances) {
      const Real values[] = {c.xx, c.xy, c.xz, c.yy, c.yz, c.zz};
      for (int k = 0; k < 6 && out.covariances; ++k) out.covariances.at(i, k) = values[k];
    } else {
      const auto shape = scaled_covariance_gradient(scale, q, c);
      const glm::qua<Real> r = rules.normalises_rotations
                                   ? unit_rotation_gradient(rotation, q, shape.rotation)
                                   : shape.rotation;
      out.scales.set(i, shape.scale);
      out.rotations.set(i, glm::vec<4, Real>(r.w, r.x, r.y, r.z));
    }

    if constexpr (!kPose) return;
    const glm::dvec3 d_point(placed.geometry.mean), position(mean);
    for (int row = 0; row < 3; ++row) {
      const glm::dvec3 through_covariance(placed.geometry.rows[row]);
      for (int column = 0; column < 3; ++column)
        pose.view_from_world[column][row] +=
            d_point[row] * position[column] + through_covariance[column];
      pose.view_from_world[3][row] += d_point[row];
    }
    pose.position -= glm::dvec3(by_direction);
  }
};

}  // namespace qs::diff
