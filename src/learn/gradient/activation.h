// SPDX-License-Identifier: MIT
//
// Gradients of activation.h: from a Gaussian's covariance and opacity to the values that are
// trained.
#pragma once

#include <cmath>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/hd.h"
#include "raster/kernel/project.h"

namespace qs {

/// A trained quaternion has any length above 0 and is normalised when it is used.
template <class Real>
QS_HD glm::qua<Real> unit_rotation(const glm::qua<Real>& rotation) {
  const Real length = std::sqrt(rotation.w * rotation.w + rotation.x * rotation.x +
                                rotation.y * rotation.y + rotation.z * rotation.z);
  return {rotation.w / length, rotation.x / length, rotation.y / length, rotation.z / length};
}

/// Passes derivatives on from unit_rotation(rotation), which is `q`, to its argument: only the part
/// across q remains.
template <class Real>
QS_HD glm::qua<Real> unit_rotation_gradient(const glm::qua<Real>& rotation, const glm::qua<Real>& q,
                                            const glm::qua<Real>& d_q) {
  const Real along = d_q.w * q.w + d_q.x * q.x + d_q.y * q.y + d_q.z * q.z;
  const Real length = std::sqrt(rotation.w * rotation.w + rotation.x * rotation.x +
                                rotation.y * rotation.y + rotation.z * rotation.z);
  return {(d_q.w - along * q.w) / length, (d_q.x - along * q.x) / length,
          (d_q.y - along * q.y) / length, (d_q.z - along * q.z) / length};
}

/// Passes derivatives on from the matrix of a quaternion q, glm::mat3_cast(q), to q, whose length
/// need not be 1.
template <class Real>
QS_HD glm::qua<Real> rotation_gradient(const glm::qua<Real>& q, const glm::mat<3, 3, Real>& d_r) {
  // The matrix by rows: 1 - 2yy - 2zz, 2xy - 2wz, 2xz + 2wy; 2xy + 2wz, 1 - 2xx - 2zz, 2yz - 2wx;
  // 2xz - 2wy, 2yz + 2wx, 1 - 2xx - 2yy. Below, e(row, column) is its gradient.
  const auto e = [&d_r](int row, int column) { return d_r[column][row]; };
  const Real w = q.w, x = q.x, y = q.y, z = q.z;
  return {2 * (x * (e(2, 1) - e(1, 2)) + y * (e(0, 2) - e(2, 0)) + z * (e(1, 0) - e(0, 1))),
          2 * (w * (e(2, 1) - e(1, 2)) + y * (e(0, 1) + e(1, 0)) + z * (e(0, 2) + e(2, 0)) -
               2 * x * (e(1, 1) + e(2, 2))),
          2 * (w * (e(0, 2) - e(2, 0)) + x * (e(0, 1) + e(1, 0)) + z * (e(1, 2) + e(2, 1)) -
               2 * y * (e(0, 0) + e(2, 2))),
          2 * (w * (e(1, 0) - e(0, 1)) + x * (e(0, 2) + e(2, 0)) + y * (e(1, 2) + e(2, 1)) -
               2 * z * (e(0, 0) + e(1, 1)))};
}

/// Passes derivatives on from a covariance to a column `m` of R diag(s): the covariance is the sum
/// of m m^T over the columns, so the derivative is 2 D m with the symmetric matrix D whose elements
/// off the diagonal are half of `d_covariance`, which counts both equal elements in xy, xz and yz.
template <class Real>
QS_HD glm::vec<3, Real> column_gradient(const Covariance3<Real>& d_covariance,
                                        const glm::vec<3, Real>& m) {
  const Covariance3<Real>& d = d_covariance;
  return {2 * d.xx * m.x + d.xy * m.y + d.xz * m.z, d.xy * m.x + 2 * d.yy * m.y + d.yz * m.z,
          d.xz * m.x + d.yz * m.y + 2 * d.zz * m.z};
}

/// Derivatives by a Gaussian's shape.
template <class Real>
struct ShapeGradient {
  glm::vec<3, Real> scale{0}, log_scale{0};
  glm::qua<Real> rotation{0, 0, 0, 0};
};

/// Passes derivatives on from scaled_covariance(scale, q) to its arguments, and to the logarithms
/// of the scales.
template <class Real>
QS_HD ShapeGradient<Real> scaled_covariance_gradient(const glm::vec<3, Real>& scale,
                                                     const glm::qua<Real>& q,
                                                     const Covariance3<Real>& d_covariance) {
  using Vec3 = glm::vec<3, Real>;
  const glm::mat<3, 3, Real> r = glm::mat3_cast(q);
  ShapeGradient<Real> result;
  glm::mat<3, 3, Real> d_r;  // columns, as r
  for (int k = 0; k < 3; ++k) {
    const Vec3 m = r[k] * scale[k], d_m = column_gradient(d_covariance, m);
    result.scale[k] = d_m.x * r[k].x + d_m.y * r[k].y + d_m.z * r[k].z;
    result.log_scale[k] = d_m.x * m.x + d_m.y * m.y + d_m.z * m.z;
    d_r[k] = d_m * scale[k];
  }
  result.rotation = rotation_gradient(q, d_r);
  return result;
}

/// Passes derivatives on from covariance_of(log_scale, unit_rotation(rotation)) to the quaternion
/// before it is normalised and to the scales. `d_covariance` counts both equal elements in xy, xz
/// and yz.
template <class Real>
QS_HD ShapeGradient<Real> covariance_gradient(const glm::vec<3, Real>& log_scale,
                                              const glm::qua<Real>& rotation,
                                              const Covariance3<Real>& d_covariance) {
  const glm::qua<Real> q = unit_rotation(rotation);
  const glm::vec<3, Real> scale(std::exp(log_scale[0]), std::exp(log_scale[1]),
                                std::exp(log_scale[2]));
  ShapeGradient<Real> result = scaled_covariance_gradient(scale, q, d_covariance);
  result.rotation = unit_rotation_gradient(rotation, q, result.rotation);
  return result;
}

/// Passes derivatives on from opacity_of(), whose result is `opacity`, to the logit.
template <class Real>
QS_HD Real opacity_gradient(Real opacity, Real d_opacity) {
  return d_opacity * opacity * (1 - opacity);
}

}  // namespace qs
