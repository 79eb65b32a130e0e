// SPDX-License-Identifier: MIT
//
// A dolly towards a target: the camera keeps its direction of sight and moves along the line to the
// target, so that the distance shrinks by the same factor at every step.
#pragma once

#include <optional>
#include <vector>

#include <glm/vec2.hpp>

#include "raster/renderer.h"

namespace qs {

/// `steps` >= 2 cameras; the first is `start`, the last is `closest` (0..1, not 0) times the first
/// distance away from the target.
std::vector<Camera> zoom_path(const Camera& start, glm::dvec3 target, int steps, double closest);

/// View depth at which the transmittance of a pixel falls to one half. `frame` is a frame of
/// `camera` with its trace. Empty if the pixel is outside the image or stays more transparent.
std::optional<double> pixel_depth(const Frame& frame, const Camera& camera, glm::ivec2 pixel);

/// The pixel that stands for the image's centre.
glm::ivec2 center_pixel(const Camera& camera);

/// The world position that is seen at a pixel, by the trace of one frame without an image.
std::optional<glm::dvec3> find_point(Renderer& renderer, const Camera& camera,
                                     RenderSettings settings, glm::ivec2 pixel);

}  // namespace qs
