// SPDX-License-Identifier: MIT
//
// The gradient of the projection (kernel/project.h, kernel/footprint.h): from a Gaussian's conic,
// opacity compensation, mean and covariance on the image to its mean and covariance in the world. A
// symmetric matrix has one value per pair of equal elements, so the derivative by xy counts both.
#pragma once

#include <cmath>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/constants.h"
#include "raster/kernel/hd.h"
#include "raster/kernel/project.h"

namespace qs {

/// Derivatives by a Gaussian's mean (in the axes that the function names) and covariance. The
/// derivative by xy, xz or yz counts both equal elements of the matrix.
template <class Real>
struct GeometryGradient {
  glm::vec<3, Real> mean{0};
  Covariance3<Real> covariance{0, 0, 0, 0, 0, 0};
  glm::vec<3, Real> rows[3]{};  ///< by the rows of the view's rotation, through the covariance
};

/// Passes derivatives on from the result of to_pixel() to the point in view axes.
template <class Real>
QS_HD glm::vec<3, Real> pixel_gradient(const View<Real>& view, const glm::vec<3, Real>& point,
                                       const glm::vec<2, Real>& d_pixel) {
  const Real x = d_pixel.x * view.focal_px.x / point.z, y = d_pixel.y * view.focal_px.y / point.z;
  return {x, y, -(x * point.x + y * point.y) / point.z};
}

/// Passes derivatives on from the slopes x/z and y/z of a point in view axes, clamped to `limits`.
/// A slope that is clamped is a constant.
template <class Real>
QS_HD void add_slope_gradient(const SlopeLimits<Real>& limits, const glm::vec<3, Real>& point,
                              const glm::vec<2, Real>& d_slope, glm::vec<3, Real>& d_point) {
  for (int axis = 0; axis < 2; ++axis) {
    const Real slope = point[axis] / point.z;
    if (!limits.contains(axis, slope)) continue;
    d_point[axis] += d_slope[axis] / point.z;
    d_point.z -= d_slope[axis] * slope / point.z;
  }
}

/// Passes derivatives on from the covariance that dilate() adds to the point in view axes.
template <class Real>
QS_HD void add_dilation_gradient(const View<Real>& view, const SlopeLimits<Real>& limits,
                                 const glm::vec<3, Real>& point, Real dilation,
                                 const Covariance2<Real>& d, glm::vec<3, Real>& d_point) {
  if (view.projection != Projection::face) return;
  const Real x = limits.clamped(0, point.x / point.z), y = limits.clamped(1, point.y / point.z);
  const Real along = 2 * dilation * (1 + x * x + y * y);
  const Real by_along = 2 * dilation * (d.xx * (1 + x * x) + d.xy * x * y + d.yy * (1 + y * y));
  add_slope_gradient(limits, point,
                     {by_along * x + along * (d.xx * x + d.xy * y / 2),
                      by_along * y + along * (d.yy * y + d.xy * x / 2)},
                     d_point);
}

/// Passes derivatives on from project_covariance() to the point in view axes, through the Jacobian,
/// to the covariance in the world and to the rotation of the view.
template <class Real>
QS_HD GeometryGradient<Real> project_covariance_gradient(const View<Real>& view,
                                                         const SlopeLimits<Real>& limits,
                                                         const glm::vec<3, Real>& point,
                                                         const Covariance3<Real>& sigma,
                                                         const Covariance2<Real>& d_covariance) {
  using Vec3 = glm::vec<3, Real>;
  const Real z = point.z;
  const Real slope_x = limits.clamped(0, point.x / z);
  const Real slope_y = limits.clamped(1, point.y / z);
  const Real j00 = view.focal_px.x / z, j02 = -view.focal_px.x * slope_x / z;
  const Real j11 = view.focal_px.y / z, j12 = -view.focal_px.y * slope_y / z;
  // Rows of W; glm stores columns, m[column][row]. u and v are the rows of J W.
  const auto& w = view.view_from_world;
  const Vec3 w0(w[0][0], w[1][0], w[2][0]), w1(w[0][1], w[1][1], w[2][1]),
      w2(w[0][2], w[1][2], w[2][2]);
  const Vec3 u = j00 * w0 + j02 * w2, v = j11 * w1 + j12 * w2;
  const auto times_sigma = [&sigma](const Vec3& a) {
    return Vec3(sigma.xx * a.x + sigma.xy * a.y + sigma.xz * a.z,
                sigma.xy * a.x + sigma.yy * a.y + sigma.yz * a.z,
                sigma.xz * a.x + sigma.yz * a.y + sigma.zz * a.z);
  };
  const Vec3 sigma_u = times_sigma(u), sigma_v = times_sigma(v);

  // xx = u^T sigma u, xy = u^T sigma v, yy = v^T sigma v.
  const Covariance2<Real>& d = d_covariance;
  GeometryGradient<Real> result;
  Covariance3<Real>& s = result.covariance;
  s.xx = d.xx * u.x * u.x + d.xy * u.x * v.x + d.yy * v.x * v.x;
  s.yy = d.xx * u.y * u.y + d.xy * u.y * v.y + d.yy * v.y * v.y;
  s.zz = d.xx * u.z * u.z + d.xy * u.z * v.z + d.yy * v.z * v.z;
  s.xy = 2 * d.xx * u.x * u.y + d.xy * (u.x * v.y + u.y * v.x) + 2 * d.yy * v.x * v.y;
  s.xz = 2 * d.xx * u.x * u.z + d.xy * (u.x * v.z + u.z * v.x) + 2 * d.yy * v.x * v.z;
  s.yz = 2 * d.xx * u.y * u.z + d.xy * (u.y * v.z + u.z * v.y) + 2 * d.yy * v.y * v.z;

  const Vec3 d_u = 2 * d.xx * sigma_u + d.xy * sigma_v;
  const Vec3 d_v = d.xy * sigma_u + 2 * d.yy * sigma_v;
  const auto dot = [](const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
  result.rows[0] = j00 * d_u;
  result.rows[1] = j11 * d_v;
  result.rows[2] = j02 * d_u + j12 * d_v;
  const Real d_j00 = dot(d_u, w0), d_j02 = dot(d_u, w2);
  const Real d_j11 = dot(d_v, w1), d_j12 = dot(d_v, w2);
  // j02 = -focal slope / z; the slope is x / z unless it is clamped.
  const Real d_slope_x = -d_j02 * view.focal_px.x / z, d_slope_y = -d_j12 * view.focal_px.y / z;
  result.mean.z = -(d_j00 * j00 + d_j02 * j02 + d_j11 * j11 + d_j12 * j12) / z;
  add_slope_gradient(limits, point, {d_slope_x, d_slope_y}, result.mean);
  return result;
}

/// Passes derivatives on from to_view() to the position in the world.
template <class Real>
QS_HD glm::vec<3, Real> view_gradient(const View<Real>& view, const glm::vec<3, Real>& d_point) {
  const auto& w = view.view_from_world;
  const auto along = [&](int column) {
    return w[column][0] * d_point.x + w[column][1] * d_point.y + w[column][2] * d_point.z;
  };
  return {along(0), along(1), along(2)};
}

/// Adds d_determinant times the derivative of the covariance's determinant.
template <class Real>
QS_HD void add_determinant_gradient(const Covariance2<Real>& covariance, Real d_determinant,
                                    Covariance2<Real>& sum) {
  sum.xx += d_determinant * covariance.yy;
  sum.xy -= d_determinant * 2 * covariance.xy;
  sum.yy += d_determinant * covariance.xx;
}

/// Passes derivatives on from the conic (yy, -xy, xx) / determinant to the dilated covariance,
/// whose determinant must be > 0.
template <class Real>
QS_HD Covariance2<Real> conic_gradient(const Covariance2<Real>& covariance,
                                       const glm::vec<3, Real>& d_conic) {
  const Real inverse = 1 / covariance.determinant();
  Covariance2<Real> result{d_conic.z * inverse, -d_conic.y * inverse, d_conic.x * inverse};
  const Real d_determinant =
      -inverse * inverse *
      (d_conic.x * covariance.yy - d_conic.y * covariance.xy + d_conic.z * covariance.xx);
  add_determinant_gradient(covariance, d_determinant, result);
  return result;
}

/// Passes derivatives on from the factor compensation(before, after): adds to the derivatives by
/// the covariance without and with the dilation. Nothing where the ratio of their determinants is
/// at its lower bound.
template <class Real>
QS_HD void add_compensation_gradient(const Covariance2<Real>& before,
                                     const Covariance2<Real>& after, Real d_factor,
                                     Covariance2<Real>& d_before, Covariance2<Real>& d_after,
                                     Real floor = Real(kCompensationFloor)) {
  const Real determinant = after.determinant();
  const Real ratio = before.determinant() / determinant;
  if (!(ratio > floor)) return;
  const Real d_ratio = d_factor / (2 * std::sqrt(ratio));
  add_determinant_gradient(before, d_ratio / determinant, d_before);
  add_determinant_gradient(after, -d_ratio * ratio / determinant, d_after);
}

}  // namespace qs
