// SPDX-License-Identifier: MIT
//
// How a camera moves: plain functions from a camera to the moved one. Angles are radians, `up` is a
// unit vector that points up in the world. Nothing here ever looks straight up or down: a pitch
// that would is left out, a yaw never is.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/scene/camera.h"

namespace qs {

/// World directions of the view axes.
struct ViewAxes {
  glm::dvec3 right{1, 0, 0}, down{0, 1, 0}, forward{0, 0, 1};
};
ViewAxes view_axes(const Camera& camera);

/// The same camera somewhere else.
Camera moved_to(const Camera& camera, glm::dvec3 position);

/// Around the pivot: positive yaw swings the camera to the left, so that the scene follows a cursor
/// to the right; positive pitch lifts it.
Camera orbited(const Camera& camera, glm::dvec3 pivot, glm::dvec3 up, double yaw, double pitch);

/// On the spot: positive yaw looks right, positive pitch looks up.
Camera turned(const Camera& camera, glm::dvec3 up, double yaw, double pitch);

/// By a step in view axes (right, down, forward), world units.
Camera stepped(const Camera& camera, glm::dvec3 step);

/// The step in view axes that makes what lies at `depth` follow the cursor by `pixels`.
glm::dvec3 pan_step(const Camera& camera, double depth, glm::dvec2 pixels);

/// Clockwise around the line of sight.
Camera rolled(const Camera& camera, double angle);

/// The vertical field of view in radians, and the camera with another one (0.5 to 170 degrees).
double vertical_fov(const Camera& camera);
Camera with_vertical_fov(const Camera& camera, double fov);

/// Depth of a point along the line of sight; the world point under a pixel at a depth.
double depth_of(const Camera& camera, glm::dvec3 point);
glm::dvec3 point_at(const Camera& camera, glm::dvec2 pixel, double depth);

}  // namespace qs
