// SPDX-License-Identifier: MIT
//
// A camera path towards a target: the camera keeps its orientation and moves along the line to the
// target, so that the distance shrinks by the same factor at every step.
#pragma once

#include <optional>
#include <vector>

#include <glm/vec2.hpp>

#include "raster/api/renderer.h"

namespace qs {

/// `steps` >= 2 cameras; the first is `start`, the last is `closest` (0..1, not 0) times the first
/// distance away from the target.
std::vector<Camera> zoom_path(const Camera& start, glm::dvec3 target, int steps, double closest);

/// The camera of zoom_path() with the number `step`, 0 to steps - 1.
Camera zoom_camera(const Camera& start, glm::dvec3 target, int steps, double closest, int step);

/// The pixel at the image's centre.
glm::ivec2 center_pixel(const Camera& camera);

/// The world position seen at a pixel, from the trace of one frame. Empty if the pixel is outside
/// the image or mostly transparent.
std::optional<glm::dvec3> find_point(Renderer& renderer, const Camera& camera,
                                     RenderSettings settings, glm::ivec2 pixel);

}  // namespace qs
