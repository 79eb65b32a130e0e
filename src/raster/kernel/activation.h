// SPDX-License-Identifier: MIT
//
// A Gaussian's covariance and opacity from the values that are stored and trained: logarithms of
// the standard deviations, a rotation and a logit. Renderers use the double precision versions,
// because exp() of float differs between backends.
#pragma once

#include <cmath>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/footprint.h"
#include "raster/kernel/hd.h"

namespace qs {

/// Covariance R diag(s^2) R^T with the standard deviations s = `scale`, world units^2. R is the
/// matrix of the quaternion by the formula for unit quaternions, also if the length is not 1.
template <class Real>
QS_HD Covariance3<Real> scaled_covariance(const glm::vec<3, Real>& scale,
                                          const glm::qua<Real>& rotation) {
  using Vec3 = glm::vec<3, Real>;
  const glm::mat<3, 3, Real> r = glm::mat3_cast(rotation);
  const Vec3 x = r[0] * scale.x, y = r[1] * scale.y, z = r[2] * scale.z;  // columns of R S
  return {x.x * x.x + y.x * y.x + z.x * z.x, x.x * x.y + y.x * y.y + z.x * z.y,
          x.x * x.z + y.x * y.z + z.x * z.z, x.y * x.y + y.y * y.y + z.y * z.y,
          x.y * x.z + y.y * y.z + z.y * z.z, x.z * x.z + y.z * y.z + z.z * z.z};
}

/// The covariance for s = exp(log_scale), which may be -inf (flat); `rotation` has length 1.
template <class Real>
QS_HD Covariance3<Real> covariance_of(const glm::vec<3, Real>& log_scale,
                                      const glm::qua<Real>& rotation) {
  return scaled_covariance(
      glm::vec<3, Real>(std::exp(log_scale.x), std::exp(log_scale.y), std::exp(log_scale.z)),
      rotation);
}

/// 1 / (1 + e^-logit); +-inf give 1 and 0.
template <class Real>
QS_HD Real opacity_of(Real logit) {
  return 1 / (1 + std::exp(-logit));
}

/// Rounds a Gaussian's values to the single precision from which footprints are made.
QS_HD ActiveGaussian active_gaussian(const glm::vec3& position, const Covariance3<double>& c,
                                     double opacity) {
  return {position,
          {static_cast<float>(c.xx), static_cast<float>(c.xy), static_cast<float>(c.xz),
           static_cast<float>(c.yy), static_cast<float>(c.yz), static_cast<float>(c.zz)},
          static_cast<float>(std::log2(255 * opacity))};
}

}  // namespace qs
