// SPDX-License-Identifier: MIT
//
// A view of a whole box: upright, slightly from above, as large as fits. The camera is oriented to
// the world's up direction; the scene is not rotated. first_view.h chooses better views of a scene;
// grids of growing size are compared in this view.
#pragma once

#include <glm/vec3.hpp>

#include "app/framing/scene_box.h"
#include "raster/scene/camera.h"

namespace qs {

/// A camera that shows the whole box at width x height with a vertical field of view of 60 degrees.
/// `smallest` is the least radius to show, because a box may have size 0. The near plane is at
/// min(0.2, 0.01 x the box's longest side).
Camera frame_box(const SceneBox& box, float smallest, glm::dvec3 up, int width, int height);

/// The least radius that frame_box() should show of this scene: three standard deviations of the
/// median Gaussian, so that a scene with one Gaussian is framed too. World units, > 0.
float smallest_framing(const GaussianCloud& cloud);

/// frame_box() of the scene's core extents.
Camera frame_scene(const GaussianCloud& cloud, glm::dvec3 up, int width, int height);

}  // namespace qs
