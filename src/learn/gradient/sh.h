// SPDX-License-Identifier: MIT
//
// Gradients of a Gaussian's colour (sh.h) by its coefficients and by the direction, and of the
// direction by the mean.
#pragma once

#include <cmath>

#include <glm/vec3.hpp>

#include "raster/kernel/constants.h"
#include "raster/kernel/hd.h"

namespace qs {

/// The gradient before the clamp at 0, of a colour before or after it: 0 for channels that are
/// clamped. A channel of exactly 0 passes its gradient on only if `zero_passes`, which requires the
/// colour before the clamp.
template <class Real>
QS_HD glm::vec<3, Real> clamp_gradient(const glm::vec<3, Real>& color,
                                       const glm::vec<3, Real>& d_color, bool zero_passes = false) {
  const auto passes = [zero_passes](Real value) {
    return value > 0 || (zero_passes && value == 0);
  };
  return {passes(color.x) ? d_color.x : Real(0), passes(color.y) ? d_color.y : Real(0),
          passes(color.z) ? d_color.z : Real(0)};
}

/// Calls add(i, gradient) for every RGB coefficient of the degree, after it was read, and returns
/// the gradient by the unit vector `d`, whose components are independent here. `d_color` is before
/// the clamp; the other arguments are as for sh_color().
template <class Real, class Coefficients, class Add>
QS_HD glm::vec<3, Real> sh_gradient(int degree, const glm::vec<3, Real>& d,
                                    const Coefficients& coefficients,
                                    const glm::vec<3, Real>& d_color, const Add& add) {
  using Vec3 = glm::vec<3, Real>;
  Vec3 d_direction(0);
  // A coefficient's basis function: its value, and its derivatives by x, y and z.
  const auto term = [&](int i, Real factor, Real value, Real by_x, Real by_y, Real by_z) {
    const Vec3 c = coefficients(i);
    add(i, factor * value * d_color);
    const Real weight = factor * (c.x * d_color.x + c.y * d_color.y + c.z * d_color.z);
    d_direction += weight * Vec3(by_x, by_y, by_z);
  };
  add(0, Real(kSh0) * d_color);
  if (degree < 1) return d_direction;
  const Real x = d.x, y = d.y, z = d.z;
  term(1, -Real(kSh1), y, 0, 1, 0);
  term(2, Real(kSh1), z, 0, 0, 1);
  term(3, -Real(kSh1), x, 1, 0, 0);
  if (degree < 2) return d_direction;
  const Real xx = x * x, yy = y * y, zz = z * z;
  term(4, Real(kSh2A), x * y, y, x, 0);
  term(5, -Real(kSh2A), y * z, 0, z, y);
  term(6, Real(kSh2B), 2 * zz - xx - yy, -2 * x, -2 * y, 4 * z);
  term(7, -Real(kSh2A), x * z, z, 0, x);
  term(8, Real(kSh2C), xx - yy, 2 * x, -2 * y, 0);
  if (degree < 3) return d_direction;
  term(9, -Real(kSh3A), y * (3 * xx - yy), 6 * x * y, 3 * xx - 3 * yy, 0);
  term(10, Real(kSh3B), x * y * z, y * z, x * z, x * y);
  term(11, -Real(kSh3C), y * (4 * zz - xx - yy), -2 * x * y, 4 * zz - xx - 3 * yy, 8 * y * z);
  term(12, Real(kSh3D), z * (2 * zz - 3 * xx - 3 * yy), -6 * x * z, -6 * y * z,
       6 * zz - 3 * xx - 3 * yy);
  term(13, -Real(kSh3C), x * (4 * zz - xx - yy), 4 * zz - 3 * xx - yy, -2 * x * y, 8 * x * z);
  term(14, Real(kSh3E), z * (xx - yy), 2 * x * z, -2 * y * z, xx - yy);
  term(15, -Real(kSh3A), x * (xx - 3 * yy), 3 * xx - 3 * yy, -6 * x * y, 0);
  return d_direction;
}

/// Passes derivatives on from the unit vector offset / |offset| to the offset, which must not be 0.
template <class Real>
QS_HD glm::vec<3, Real> direction_gradient(const glm::vec<3, Real>& offset,
                                           const glm::vec<3, Real>& d_direction) {
  const Real length = std::sqrt(offset.x * offset.x + offset.y * offset.y + offset.z * offset.z);
  const glm::vec<3, Real> d = offset / length;
  const Real along = d.x * d_direction.x + d.y * d_direction.y + d.z * d_direction.z;
  return (d_direction - along * d) / length;
}

}  // namespace qs
