// SPDX-License-Identifier: MIT
//
// The vectors that codes of shapes stand for: standard deviations, and unit quaternions with w >= 0
// as w, x, y, z. Exponentials and logarithms are computed in double precision, so that all backends
// round them to the same vectors.
#pragma once

#include <cmath>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/hd.h"

namespace qs {

inline constexpr unsigned kScaleValues = 3, kRotationValues = 4;

QS_HD void scale_vector(const glm::vec3& log_scale, float* values) {
  for (int k = 0; k < 3; ++k)
    values[k] = static_cast<float>(std::exp(static_cast<double>(log_scale[k])));
}

/// A coded deviation counts by its absolute value, which is at least 1e-12.
QS_HD glm::vec3 coded_log_scale(const float* values) {
  constexpr double kLeast = 1e-12;
  glm::vec3 result;
  for (int k = 0; k < 3; ++k) {
    const double scale = std::abs(static_cast<double>(values[k]));
    result[k] = static_cast<float>(std::log(scale > kLeast ? scale : kLeast));
  }
  return result;
}

/// The factor by which a quaternion is divided.
QS_HD float turning_factor(const glm::quat& rotation) {
  const float length = std::sqrt(rotation.w * rotation.w + rotation.x * rotation.x +
                                 rotation.y * rotation.y + rotation.z * rotation.z);
  return rotation.w < 0 ? -length : length;
}

QS_HD void rotation_vector(const glm::quat& rotation, float* values) {
  const float factor = turning_factor(rotation);
  values[0] = rotation.w / factor;
  values[1] = rotation.x / factor;
  values[2] = rotation.y / factor;
  values[3] = rotation.z / factor;
}

}  // namespace qs
