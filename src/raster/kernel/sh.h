// SPDX-License-Identifier: MIT
//
// Colour of a Gaussian in a direction: real spherical harmonics up to degree 3 (3DGS).
#pragma once

#include <array>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/constants.h"
#include "raster/kernel/hd.h"

namespace qs {

/// RGB >= 0 (no upper clamp) for the unit vector `d` from the camera to the Gaussian, world axes.
/// `coefficients(i)` returns RGB coefficient i as vec<3, Real>, i < (degree + 1)^2; degree 0..3.
template <class Real, class Coefficients>
QS_HD glm::vec<3, Real> sh_color(int degree, const glm::vec<3, Real>& d,
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
      if (degree > 2) {
        color += Real(kSh3B) * x * y * z * coefficients(10) -
                 Real(kSh3A) *
                     (y * (3 * xx - yy) * coefficients(9) + x * (xx - 3 * yy) * coefficients(15)) -
                 Real(kSh3C) * (4 * zz - xx - yy) * (y * coefficients(11) + x * coefficients(13)) +
                 Real(kSh3D) * z * (2 * zz - 3 * xx - 3 * yy) * coefficients(12) +
                 Real(kSh3E) * z * (xx - yy) * coefficients(14);
      }
    }
  }
  return glm::max(color + Real(0.5), Vec3(0));
}

/// The 16 functions of degrees 0 to 3 at the unit vector `d`. sh_color() is their sum with the
/// coefficients, plus 1/2, before the clamp.
inline std::array<double, 16> sh_basis(const glm::dvec3& d) {
  const double x = d.x, y = d.y, z = d.z, xx = x * x, yy = y * y, zz = z * z;
  return {kSh0,
          -kSh1 * y,
          kSh1 * z,
          -kSh1 * x,
          kSh2A * x * y,
          -kSh2A * y * z,
          kSh2B * (2 * zz - xx - yy),
          -kSh2A * x * z,
          kSh2C * (xx - yy),
          -kSh3A * y * (3 * xx - yy),
          kSh3B * x * y * z,
          -kSh3C * y * (4 * zz - xx - yy),
          kSh3D * z * (2 * zz - 3 * xx - 3 * yy),
          -kSh3C * x * (4 * zz - xx - yy),
          kSh3E * z * (xx - yy),
          -kSh3A * x * (xx - 3 * yy)};
}

}  // namespace qs
