// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "io/scene/compact/compact_model.h"

namespace qs {
namespace {

constexpr int kMaxSweeps = 30;

// Turns pairs of columns until all are perpendicular (Hestenes 1958). Their product with their
// transposed matrix stays the same.
void make_perpendicular(glm::dmat3& m) {
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    bool turned = false;
    for (const auto& [p, q] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
      const double a = glm::dot(m[p], m[p]), b = glm::dot(m[q], m[q]), c = glm::dot(m[p], m[q]);
      if (!(std::abs(c) > 1e-15 * std::sqrt(a * b)) || c == 0) continue;
      turned = true;
      const double theta = (b - a) / (2 * c);
      const double tangent =
          std::copysign(1 / (std::abs(theta) + std::sqrt(1 + theta * theta)), theta);
      const double cosine = 1 / std::sqrt(1 + tangent * tangent), sine = cosine * tangent;
      const glm::dvec3 first = m[p];
      m[p] = cosine * first - sine * m[q];
      m[q] = sine * first + cosine * m[q];
    }
    if (!turned) return;
  }
}

// A unit vector that is perpendicular to the unit vector `v`.
glm::dvec3 perpendicular_to(const glm::dvec3& v) {
  const glm::dvec3 other = std::abs(v.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(v, other));
}

}  // namespace

ShapeOfGaussian shape_of_raw_rotation(const glm::vec4& quaternion, const glm::vec3& scale) {
  const double w = static_cast<double>(quaternion.x), x = static_cast<double>(quaternion.y),
               y = static_cast<double>(quaternion.z), z = static_cast<double>(quaternion.w);
  ShapeOfGaussian shape;
  const double square = w * w + x * x + y * y + z * z;
  if (!std::isfinite(square + static_cast<double>(scale.x + scale.y + scale.z))) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    shape.rotation = {kNan, kNan, kNan, kNan};
    return shape;
  }
  glm::dmat3 m(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
               2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
               2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y));
  for (int axis = 0; axis < 3; ++axis) m[axis] *= static_cast<double>(scale[axis]);
  if (std::abs(square - 1) > 1e-7) make_perpendicular(m);

  glm::dvec3 lengths(glm::length(m[0]), glm::length(m[1]), glm::length(m[2]));
  glm::dmat3 axes(0);
  std::array<int, 3> flat{};
  std::size_t flats = 0;
  for (int axis = 0; axis < 3; ++axis) {
    shape.log_scale[axis] = static_cast<float>(std::log(lengths[axis]));
    if (lengths[axis] > 0)
      axes[axis] = m[axis] / lengths[axis];
    else
      flat[flats++] = axis;
  }
  // Directions without extent are any that complete the axes.
  if (flats == 3) return shape;
  if (flats == 2) {
    const int whole = 3 - flat[0] - flat[1];
    axes[flat[0]] = perpendicular_to(axes[whole]);
  }
  if (flats > 0) {
    const int last = flat[flats - 1];
    axes[last] = glm::cross(axes[(last + 1) % 3], axes[(last + 2) % 3]);
  }
  if (glm::determinant(axes) < 0) axes[0] = -axes[0];
  shape.rotation = glm::quat(glm::normalize(glm::quat_cast(axes)));
  return shape;
}

}  // namespace qs
