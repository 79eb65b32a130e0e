// SPDX-License-Identifier: MIT
//
// A dolly towards a target: the camera keeps its direction of sight and moves along the line to the
// target, so that the distance shrinks by the same factor at every step.
#pragma once

#include <optional>
#include <vector>

#include "raster/renderer.h"

namespace qs {

/// `steps` >= 2 cameras; the first is `start`, the last is `closest` (0..1, not 0) times the first
/// distance away from the target.
std::vector<Camera> zoom_path(const Camera& start, glm::dvec3 target, int steps, double closest);

/// View depth at which light of the image's centre is half absorbed, from a frame's trace; empty
/// when it never is.
std::optional<double> center_depth(const Trace& trace, const Camera& camera);

/// The world position at this view depth under the image's centre.
glm::dvec3 center_point(const Camera& camera, double depth);

}  // namespace qs
