// SPDX-License-Identifier: MIT
//
// Estimates the up direction of a scene without cameras, from the principal axes of its surfaces.
#pragma once

#include <string_view>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "app/framing/subject.h"

namespace qs {

/// The world's up direction for the vertical axis named in a file ("y", "-z", "Z", "+x"). Any other
/// text gives -Y, as in scenes trained from photographs (RDF).
glm::dvec3 world_up(std::string_view vertical_axis);

struct UpEstimate {
  glm::dvec3 up;  ///< unit vector
  /// True if the likeliest floor is above the subject when `up` points up, as in a file that
  /// declares the wrong axes.
  bool upside_down = false;
  /// True if there is a floor, below or above. Without one the scene may also stand on its head,
  /// and `up` follows the convention.
  bool has_floor = false;
};

/// Up is the upward normal of the subject's floor: the plane that holds most of its Gaussians, if
/// these are at least a tenth of all Gaussians and the normal is within 60 degrees of `convention`.
/// Large Gaussians and flat Gaussians parallel to the plane count most, and planes with many
/// Gaussians above them are preferred. Without such a plane, up is the axis perpendicular to the
/// normals of flat Gaussians (walls), else `convention`.
UpEstimate estimate_up(const CloudSample& sample, const Subject& subject, glm::dvec3 convention);

/// Unit eigenvectors and their eigenvalues, in ascending order.
struct PrincipalAxes {
  glm::dvec3 axis[3];
  double value[3];
};

/// `matrix` is symmetric and finite.
PrincipalAxes principal_axes(const glm::dmat3& matrix);

}  // namespace qs
