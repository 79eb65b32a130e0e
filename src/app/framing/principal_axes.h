// SPDX-License-Identifier: MIT
//
// The principal axes of directions or points: the eigenvectors of a symmetric matrix.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace qs {

/// Unit eigenvectors and their eigenvalues, in ascending order.
struct PrincipalAxes {
  glm::dvec3 axis[3];
  double value[3];
};

/// `matrix` is symmetric and finite.
PrincipalAxes principal_axes(const glm::dmat3& matrix);

}  // namespace qs
