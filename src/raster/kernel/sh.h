// SPDX-License-Identifier: MIT
//
// Colour of a Gaussian in a direction: real spherical harmonics up to degree 3 (3DGS).
#pragma once

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/constants.h"
#include "raster/kernel/hd.h"

namespace qs {

/// RGB before the clamp at 0, for the unit vector `d` from the camera to the Gaussian, world axes.
/// `coefficients(i)` returns RGB coefficient i as vec<3, Real>, i < (degree + 1)^2; degree 0..3.
template <class Real, class Coefficients>
QS_HD glm::vec<3, Real> unclamped_sh_color(int degree, const glm::vec<3, Real>& d,
                                           const Coefficients& coefficients) {
  using Vec3 = glm::vec<3, Real>;
  Vec3 color = Real(kSh0) * coefficients(0);
  if (degree > 0) {
    const Real x = d.x, y = d.y, z = d.z;
    color += Real(kSh1) * (z * coefficients(2) - y * coefficients(1) - x * coefficients(3));
    if (degree > 1) {
      const Real xx = x * x, yy = y * y, zz = z * z;
      color += Real(kSh2A) *
                   (x * y * coefficients(4) - y * z * coefficients(5) - x * z * coefficients(7)) +
               Real(kSh2B) * (2 * zz - xx - yy) * coefficients(6) +
               Real(kSh2C) * (xx - yy) * coefficients(8);
      if (degree > 2)
        color += Real(kSh3B) * x * y * z * coefficients(10) -
                 Real(kSh3A) *
                     (y * (3 * xx - yy) * coefficients(9) + x * (xx - 3 * yy) * coefficients(15)) -
                 Real(kSh3C) * (4 * zz - xx - yy) * (y * coefficients(11) + x * coefficients(13)) +
                 Real(kSh3D) * z * (2 * zz - 3 * xx - 3 * yy) * coefficients(12) +
                 Real(kSh3E) * z * (xx - yy) * coefficients(14);
    }
  }
  return color + Real(0.5);
}

/// The colour clamped to RGB >= 0; there is no upper clamp.
template <class Real, class Coefficients>
QS_HD glm::vec<3, Real> sh_color(int degree, const glm::vec<3, Real>& d,
                                 const Coefficients& coefficients) {
  return glm::max(unclamped_sh_color(degree, d, coefficients), glm::vec<3, Real>(0));
}

/// Writes the 16 functions of degrees 0 to 3 at the unit vector `d`. sh_color() is the sum of their
/// products with the coefficients, plus 1/2, before the clamp.
template <class Real>
QS_HD void sh_basis(const glm::vec<3, Real>& d, Real* values) {
  const Real x = d.x, y = d.y, z = d.z, xx = x * x, yy = y * y, zz = z * z;
  values[0] = Real(kSh0);
  values[1] = -Real(kSh1) * y;
  values[2] = Real(kSh1) * z;
  values[3] = -Real(kSh1) * x;
  values[4] = Real(kSh2A) * x * y;
  values[5] = -Real(kSh2A) * y * z;
  values[6] = Real(kSh2B) * (2 * zz - xx - yy);
  values[7] = -Real(kSh2A) * x * z;
  values[8] = Real(kSh2C) * (xx - yy);
  values[9] = -Real(kSh3A) * y * (3 * xx - yy);
  values[10] = Real(kSh3B) * x * y * z;
  values[11] = -Real(kSh3C) * y * (4 * zz - xx - yy);
  values[12] = Real(kSh3D) * z * (2 * zz - 3 * xx - 3 * yy);
  values[13] = -Real(kSh3C) * x * (4 * zz - xx - yy);
  values[14] = Real(kSh3E) * z * (xx - yy);
  values[15] = -Real(kSh3A) * x * (xx - 3 * yy);
}

}  // namespace qs
