// SPDX-License-Identifier: MIT
//
// The steps from a Gaussian in the world to its footprint on the image (EWA splatting with the
// rules of 3DGS). Real is float in every backend and double in mode reference. The code uses only +
// - * / and sqrt in source order, so that CPU and GPU get the same bits.
#pragma once

#include <cmath>

#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/constants.h"
#include "raster/kernel/hd.h"
#include "raster/kernel/view.h"

namespace qs {

/// A symmetric 3x3 matrix: xx xy xz yy yz zz.
template <class Real>
struct Covariance3 {
  Real xx, xy, xz, yy, yz, zz;
};

/// A symmetric 2x2 matrix.
template <class Real>
struct Covariance2 {
  Real xx, xy, yy;
  QS_HD Real determinant() const { return xx * yy - xy * xy; }
};

/// The area of the image that a Gaussian covers: pixels with a dx^2 + 2 b dx dy + c dy^2 <= gamma
/// have alpha >= 1/255.
struct Footprint {
  glm::vec2 mean_px;
  Covariance2<float> covariance;  ///< px^2, dilated
  glm::vec3 conic;                ///< (a, b, c) = (yy, -xy, xx) / determinant
  float determinant;              ///< determinant of the covariance, > 0
  float gamma;                    ///< 2 ln(255 opacity); > 0 unless the mode keeps faint Gaussians

  QS_HD bool is_solid() const { return gamma >= kSolidGamma; }
};

/// The world position `position` in view axes.
template <class Real>
QS_HD glm::vec<3, Real> to_view(const View<Real>& view, const glm::vec<3, Real>& position) {
  return view.view_from_world * glm::vec<4, Real>(position, Real(1));
}

/// The depth of a point in view axes by which the view sorts; a Gaussian is drawn if it is above
/// View::near_depth.
template <class Real>
QS_HD Real depth_of(const View<Real>& view, const glm::vec<3, Real>& point) {
  if (view.projection != Projection::face || !(point.z > Real(0))) return point.z;
  return std::sqrt(point.x * point.x + point.y * point.y + point.z * point.z);
}

/// The point in view axes from which to_pixel() and project_covariance() project: at z = 1 both are
/// orthographic, with slope limits of 0.
template <class Real>
QS_HD glm::vec<3, Real> projected_point(const View<Real>& view, const glm::vec<3, Real>& point) {
  return {point.x, point.y, view.projection == Projection::orthographic ? Real(1) : point.z};
}

/// Pixel coordinates of a point in view axes, z > 0.
template <class Real>
QS_HD glm::vec<2, Real> to_pixel(const View<Real>& view, const glm::vec<3, Real>& point) {
  return {view.focal_px.x * (point.x / point.z) + view.center_px.x,
          view.focal_px.y * (point.y / point.z) + view.center_px.y};
}

/// `value` limited to low..high.
template <class Real>
QS_HD Real clamped(Real value, Real low, Real high) {
  return value < low ? low : (value > high ? high : value);
}

/// The range of the slopes x/z and y/z inside the Jacobian of the projection.
template <class Real>
struct SlopeLimits {
  glm::vec<2, Real> low, high;

  static QS_HD SlopeLimits of(const View<Real>& view) {
    return {-view.slope_limit, view.slope_limit};
  }
  /// `axis` is 0 for x and 1 for y.
  QS_HD Real clamped(int axis, Real slope) const {
    return qs::clamped(slope, low[axis], high[axis]);
  }
  QS_HD bool contains(int axis, Real slope) const {
    return !(slope < low[axis] || slope > high[axis]);
  }
};

/// Covariance on the image in px^2, without the dilation: J W Sigma W^T J^T with the Jacobian J of
/// the perspective projection at `point` (view axes, z > 0), its slopes clamped to `limits`.
template <class Real>
QS_HD Covariance2<Real> project_covariance(const View<Real>& view, const SlopeLimits<Real>& limits,
                                           const glm::vec<3, Real>& point,
                                           const Covariance3<Real>& sigma) {
  using Vec3 = glm::vec<3, Real>;
  const Real tx = limits.clamped(0, point.x / point.z) * point.z;
  const Real ty = limits.clamped(1, point.y / point.z) * point.z;
  const Real zz = point.z * point.z;
  const Real j00 = view.focal_px.x / point.z, j02 = -(view.focal_px.x * tx) / zz;
  const Real j11 = view.focal_px.y / point.z, j12 = -(view.focal_px.y * ty) / zz;
  // Rows of J W; glm stores columns, m[column][row].
  const auto& w = view.view_from_world;
  const Vec3 u(j00 * w[0][0] + j02 * w[0][2], j00 * w[1][0] + j02 * w[1][2],
               j00 * w[2][0] + j02 * w[2][2]);
  const Vec3 v(j11 * w[0][1] + j12 * w[0][2], j11 * w[1][1] + j12 * w[1][2],
               j11 * w[2][1] + j12 * w[2][2]);
  const Vec3 sigma_u(sigma.xx * u.x + sigma.xy * u.y + sigma.xz * u.z,
                     sigma.xy * u.x + sigma.yy * u.y + sigma.yz * u.z,
                     sigma.xz * u.x + sigma.yz * u.y + sigma.zz * u.z);
  const Vec3 sigma_v(sigma.xx * v.x + sigma.xy * v.y + sigma.xz * v.z,
                     sigma.xy * v.x + sigma.yy * v.y + sigma.yz * v.z,
                     sigma.xz * v.x + sigma.yz * v.y + sigma.zz * v.z);
  return {u.x * sigma_u.x + u.y * sigma_u.y + u.z * sigma_u.z,
          v.x * sigma_u.x + v.y * sigma_u.y + v.z * sigma_u.z,
          v.x * sigma_v.x + v.y * sigma_v.y + v.z * sigma_v.z};
}

/// The same covariance with slopes clamped to view.slope_limit.
template <class Real>
QS_HD Covariance2<Real> project_covariance(const View<Real>& view, const glm::vec<3, Real>& point,
                                           const Covariance3<Real>& sigma) {
  return project_covariance(view, SlopeLimits<Real>::of(view), point, sigma);
}

/// Adds the dilation, px^2, to a covariance on the image. In a face it is a circle of directions
/// around the one to the point, of one angle all over the face, because the lens's picture has no
/// faces: a pixel of a face covers a smaller angle towards its edge.
template <class Real>
QS_HD void dilate(const View<Real>& view, const SlopeLimits<Real>& limits,
                  const glm::vec<3, Real>& point, Real dilation, Covariance2<Real>& covariance) {
  if (view.projection != Projection::face) {
    covariance.xx = covariance.xx + dilation;
    covariance.yy = covariance.yy + dilation;
    return;
  }
  const Real x = limits.clamped(0, point.x / point.z), y = limits.clamped(1, point.y / point.z);
  const Real along = dilation * (Real(1) + x * x + y * y);
  covariance.xx = covariance.xx + along * (Real(1) + x * x);
  covariance.xy = covariance.xy + along * (x * y);
  covariance.yy = covariance.yy + along * (Real(1) + y * y);
}

/// log2(x) for x in (0, 1], relative error about 1e-6. Uses only + - * /, so that every backend
/// gets the same bits when the logarithm decides about listed tiles.
QS_HD float log2_portable(float x) {
  // x = m * 2^e with m in [sqrt(1/2), sqrt(2)), by exact scaling.
  float e = 0.0f;
  for (int i = 0; i < 32 && x < 0.70710678f; ++i) {
    x = x * 2.0f;
    e = e - 1.0f;
  }
  // ln m = 2 atanh(t), t = (m-1)/(m+1), |t| < 0.172: t^9 is below 1.3e-7.
  const float t = (x - 1.0f) / (x + 1.0f);
  const float tt = t * t;
  const float series = 1.0f + tt * (1.0f / 3 + tt * (1.0f / 5 + tt * (1.0f / 7)));
  return e + 2.0f * static_cast<float>(kLog2E) * t * series;
}

/// Opacity factor of models trained with Mip-Splatting: it keeps the integral of the dilated
/// Gaussian. Arguments: determinants of the covariance before and after the dilation, after > 0,
/// and the lower bound of their ratio.
template <class Real>
QS_HD Real compensation(Real before, Real after, Real floor = Real(kCompensationFloor)) {
  const Real ratio = before / after;
  return std::sqrt(ratio > floor ? ratio : floor);
}

}  // namespace qs
