// SPDX-License-Identifier: MIT
//
// The view of a scene that nobody gave a camera for: upright, a little from above, as large as
// fits. The camera is turned to the world's up; data is never turned.
#pragma once

#include <string_view>

#include <glm/vec3.hpp>

#include "app/session/scene_box.h"
#include "raster/scene/camera.h"

namespace qs {

/// Up of the world for what a file calls its vertical axis ("y", "-z", "Z", "+x"); -Y when it says
/// nothing or something else, as in scenes trained from photographs (RDF).
glm::dvec3 world_up(std::string_view vertical_axis);

/// A camera that shows `box` whole at width x height with a vertical field of view of 60 degrees.
/// `smallest` is the radius shown at least (a box may have size 0). Its near plane is
/// min(0.2, 0.01 x the box's longest side).
Camera frame_box(const SceneBox& box, float smallest, glm::dvec3 up, int width, int height);

/// What frame_box() should show at least of this scene: three standard deviations of a typical
/// Gaussian, so that a scene of one is framed too; world units, > 0.
float smallest_framing(const GaussianCloud& cloud);

/// frame_box() of the scene's core extents.
Camera frame_scene(const GaussianCloud& cloud, std::string_view vertical_axis, int width,
                   int height);

}  // namespace qs
