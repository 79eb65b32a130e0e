// SPDX-License-Identifier: MIT
//
// The camera as kernels read it. make_view() in scene/camera.h creates it.
#pragma once

#include <glm/mat4x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace qs {

/// View axes are RDF; pixel i has its centre at coordinate i.
template <class Real>
struct View {
  glm::mat<4, 3, Real> view_from_world;
  glm::vec<3, Real> position;  ///< position of the camera, world
  glm::vec<2, Real> focal_px;
  glm::vec<2, Real> center_px;
  glm::vec<2, Real> slope_limit;  ///< |x/z| and |y/z| are clamped to this inside the Jacobian
  Real near_depth;
};

}  // namespace qs
