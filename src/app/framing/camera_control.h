// SPDX-License-Identifier: MIT
//
// Camera movements: each function returns the moved camera. Angles are in radians, `up` is a unit
// vector that points up in the world. A pitch that would end within 2 degrees of straight up or
// down is ignored; the yaw of the same call is applied.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/scene/camera.h"

namespace qs {

/// Unit vectors of the view axes in world space.
struct ViewAxes {
  glm::dvec3 right{1, 0, 0}, down{0, 1, 0}, forward{0, 0, 1};
};
ViewAxes view_axes(const Camera& camera);

/// The same camera at another position.
Camera moved_to(const Camera& camera, glm::dvec3 position);

/// Rotates around the pivot. Positive yaw moves the camera to its left, so that the scene follows a
/// cursor that moves right; positive pitch raises the camera.
Camera orbited(const Camera& camera, glm::dvec3 pivot, glm::dvec3 up, double yaw, double pitch);

/// Rotates in place: positive yaw looks right, positive pitch looks up.
Camera turned(const Camera& camera, glm::dvec3 up, double yaw, double pitch);

/// Moves by a step in view axes (right, down, forward), in world units.
Camera stepped(const Camera& camera, glm::dvec3 step);

/// The step in view axes that moves points at `depth` by `pixels` (right, down) in the image.
glm::dvec3 pan_step(const Camera& camera, double depth, glm::dvec2 pixels);

/// Rotates clockwise around the viewing direction.
Camera rolled(const Camera& camera, double angle);

/// The vertical field of view, and the camera with another field of view, clamped to 0.5 .. 170
/// degrees.
double vertical_fov(const Camera& camera);
Camera with_vertical_fov(const Camera& camera, double fov);

/// The depth of a point along the viewing direction, and the world point under a pixel at a depth.
double depth_of(const Camera& camera, glm::dvec3 point);
glm::dvec3 point_at(const Camera& camera, glm::dvec2 pixel, double depth);

}  // namespace qs
