// SPDX-License-Identifier: MIT
#include "io/scene/axes.h"

#include <array>

namespace qs {

void flip_axes(GaussianCloud& cloud, std::size_t begin, std::size_t end, AxisSigns signs) {
  if (signs.is_identity()) return;
  const float x = signs.x, y = signs.y, z = signs.z;
  // D R D with D = diag(signs) is the rotation in the new frame, for either determinant of D.
  const glm::vec3 axis_signs(y * z, x * z, x * y);
  // Every real SH function of degree <= 3 is even or odd in each coordinate; the order is Y_0^0,
  // then m = -l..l per degree l, as in kernel/sh.h.
  const std::array<float, sh_coefficient_count(kMaxShDegree)> sh_signs = {
      1,     y,         z, x,         //
      x * y, y * z,     1, x * z, 1,  //
      y,     x * y * z, y, z,     x, z, x};

  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  for (std::size_t i = begin; i < end; ++i) {
    cloud.positions[i] *= glm::vec3(x, y, z);
    glm::quat& q = cloud.rotations[i];
    q = glm::quat(q.w, q.x * axis_signs.x, q.y * axis_signs.y, q.z * axis_signs.z);
    glm::vec3* const sh = &cloud.sh[i * coefficients];
    for (std::size_t k = 1; k < coefficients; ++k) sh[k] *= sh_signs[k];
  }
}

}  // namespace qs
