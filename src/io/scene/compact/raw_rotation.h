// SPDX-License-Identifier: MIT
//
// Gaussians whose quaternion is used as it is stored, of a length that is not 1. The published
// renderers of 3DGS build a matrix from it that is no rotation: for q = s u with a unit u it is
// (1 - s^2) I + s^2 R(u).
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace qs {

struct ShapeOfGaussian {
  glm::quat rotation{1, 0, 0, 0};  ///< unit
  glm::vec3 log_scale{0};          ///< -inf = flat
};

/// The rotation and the scales with the covariance that `quaternion` (w, x, y, z) and the standard
/// deviations `scale`, of any sign, give in these renderers. If a value is infinite or NaN, so is
/// the rotation.
ShapeOfGaussian shape_of_raw_rotation(const glm::vec4& quaternion, const glm::vec3& scale);

}  // namespace qs
