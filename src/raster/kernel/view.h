// SPDX-License-Identifier: MIT
//
// The camera as kernels read it. make_view() in scene/camera.h creates it.
#pragma once

#include <glm/mat4x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace qs {

/// The way in which points are shown in a picture, and the depth by which its frame is sorted.
enum class Projection {
  pinhole,      ///< in perspective, by view z
  face,         ///< in perspective, by the distance from the eye: one of several pictures that meet
  orthographic  ///< along parallel rays, by view z; the focal lengths are pixels per world unit
};

/// View axes are RDF; pixel i has its centre at coordinate i.
template <class Real>
struct View {
  glm::mat<4, 3, Real> view_from_world;
  glm::vec<3, Real> position;  ///< position of the camera, world; far behind it if orthographic
  glm::vec<2, Real> focal_px;
  glm::vec<2, Real> center_px;
  glm::vec<2, Real> slope_limit;  ///< |x/z| and |y/z| are clamped to this inside the Jacobian
  Real near_depth;
  Projection projection = Projection::pinhole;
};

}  // namespace qs
