// SPDX-License-Identifier: MIT
//
// Residual codes of shapes in training (learn/field/code_training.h): the step by which codes
// follow their vectors, the vectors that codes stand for, and gradients straight through codes,
// from a coded shape to the shape that it stands for. Vectors are standard deviations, and unit
// quaternions with w >= 0 as w, x, y, z. Exponentials and logarithms are computed in double
// precision, so that all backends round them to the same vectors.
#pragma once

#include <cmath>
#include <cstddef>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "learn/gradient/adam.h"
#include "raster/kernel/hd.h"

namespace qs {

/// The derivative of the mean squared difference, over `values` values of all vectors, by a value
/// of a code: `sum` adds up the differences to the code's vectors.
QS_HD float code_gradient(double sum, std::size_t values) {
  return static_cast<float>(2 / static_cast<double>(values) * sum);
}

/// Adam's step of one value of a code, with rate 1e-4 and epsilon 1e-8. A gradient that is not
/// finite counts as 0.
QS_HD void move_code(const AdamStep& step, float gradient, float& value, float& first,
                     float& second) {
  constexpr float kRate = 1e-4f, kEpsilon = 1e-8f;
  constexpr auto kRest1 = static_cast<float>(1 - kAdamBeta1),
                 kRest2 = static_cast<float>(1 - kAdamBeta2);
  if (!(gradient - gradient == 0.0f)) gradient = 0.0f;
  first += kRest1 * (gradient - first);
  second += kRest2 * (gradient * gradient - second);
  value -= kRate * step.first * first / (std::sqrt(second) * step.second + kEpsilon);
}

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

/// The derivative by a deviation is the derivative by the coded deviation. The sign of a coded
/// deviation does not matter: where it is negative, the deviation that it stands for is near 0.
QS_HD glm::vec3 coded_scale_gradient(const glm::vec3& log_scale, const glm::vec3& coded,
                                     const glm::vec3& by_coded) {
  glm::vec3 by;
  for (int k = 0; k < 3; ++k)
    by[k] =
        by_coded[k] * static_cast<float>(std::exp(static_cast<double>(log_scale[k] - coded[k])));
  return by;
}

/// Through rotation_vector().
QS_HD glm::quat coded_rotation_gradient(const glm::quat& rotation, const glm::quat& by_coded) {
  float unit[4];
  rotation_vector(rotation, unit);
  const float factor = turning_factor(rotation);
  const glm::quat& d = by_coded;
  const float along = d.w * unit[0] + d.x * unit[1] + d.y * unit[2] + d.z * unit[3];
  return {(d.w - unit[0] * along) / factor, (d.x - unit[1] * along) / factor,
          (d.y - unit[2] * along) / factor, (d.z - unit[3] * along) / factor};
}

}  // namespace qs
