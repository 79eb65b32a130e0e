// SPDX-License-Identifier: MIT
//
// Which way is up in a scene without cameras.
#pragma once

#include <string_view>

#include "app/framing/subject.h"

namespace qs {

/// The world's up direction for the vertical axis named in a file ("y", "-z", "Z", "+x"). Any other
/// text gives -Y, as in scenes trained from photographs (RDF).
glm::dvec3 world_up(std::string_view vertical_axis);

struct UpEstimate {
  glm::dvec3 up;  ///< unit vector
  /// The subject hangs from its floor, as in a file that states the wrong axes: with `up` up, the
  /// likeliest floor is overhead.
  bool upside_down = false;
};

/// Up is the upward normal of the subject's floor: the plane that holds most of its Gaussians, if
/// they are a tenth of all and the normal is within 60 degrees of `convention`. Large Gaussians
/// count most, flat ones that are parallel to the plane, and planes with much above them. Without
/// such a plane the axis perpendicular to the normals of flat Gaussians, walls. Else `convention`.
UpEstimate estimate_up(const CloudSample& sample, const Subject& subject, glm::dvec3 convention);

}  // namespace qs
