// SPDX-License-Identifier: MIT
//
// Gradients straight through codes: from a coded shape to the shape that it stands for.
#pragma once

#include <cmath>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "learn/gradient/shape_of_codes.h"
#include "raster/kernel/hd.h"

namespace qs {

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
