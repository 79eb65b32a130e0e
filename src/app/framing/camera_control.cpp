// SPDX-License-Identifier: MIT
#include "app/framing/camera_control.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

namespace qs {
namespace {

constexpr double kNearestToPole = glm::radians(2.0);

// Rotates the camera's pose by `rotation`, in world space, around `center`.
Camera rotated_about(const Camera& camera, const glm::dmat3& rotation, glm::dvec3 center) {
  const glm::dmat3 view = glm::dmat3(camera.view_from_world) * glm::transpose(rotation);
  const glm::dvec3 position = center + rotation * (camera.position() - center);
  Camera result = camera;
  // Orthonormalised, so that rounding does not accumulate to a sheared view.
  glm::dvec3 right = glm::normalize(glm::dvec3(view[0][0], view[1][0], view[2][0]));
  glm::dvec3 down(view[0][1], view[1][1], view[2][1]);
  down = glm::normalize(down - glm::dot(down, right) * right);
  const glm::dmat3 rows(right, down, glm::cross(right, down));
  const glm::dmat3 clean = glm::transpose(rows);
  result.view_from_world = glm::dmat4x3(clean[0], clean[1], clean[2], -(clean * position));
  return result;
}

glm::dmat3 turn(glm::dvec3 axis, double angle) {
  return glm::mat3_cast(glm::angleAxis(angle, axis));
}

double to_pole(glm::dvec3 forward, glm::dvec3 up) {
  const double angle = std::acos(std::clamp(glm::dot(forward, up), -1.0, 1.0));
  return std::min(angle, glm::pi<double>() - angle);
}

// Pitch around the camera's right axis, unless it ends near or beyond a pole, then yaw around `up`.
glm::dmat3 yaw_and_pitch(const Camera& camera, glm::dvec3 up, double yaw, double pitch) {
  const ViewAxes axes = view_axes(camera);
  const glm::dmat3 lift = turn(axes.right, pitch);
  const glm::dvec3 from = axes.forward, to = lift * axes.forward;
  const bool crosses = glm::dot(from, to) < glm::dot(from, up) * glm::dot(to, up);
  const bool leaves = to_pole(to, up) > to_pole(from, up);
  const bool allowed = !crosses && (leaves || to_pole(to, up) > kNearestToPole);
  return allowed ? turn(up, yaw) * lift : turn(up, yaw);
}

}  // namespace

ViewAxes view_axes(const Camera& camera) {
  const glm::dmat3 world_from_view = glm::transpose(glm::dmat3(camera.view_from_world));
  return {world_from_view[0], world_from_view[1], world_from_view[2]};
}

Camera moved_to(const Camera& camera, glm::dvec3 position) {
  Camera result = camera;
  result.view_from_world[3] = -(glm::dmat3(camera.view_from_world) * position);
  return result;
}

Camera orbited(const Camera& camera, glm::dvec3 pivot, glm::dvec3 up, double yaw, double pitch) {
  return rotated_about(camera, yaw_and_pitch(camera, up, -yaw, -pitch), pivot);
}

Camera turned(const Camera& camera, glm::dvec3 up, double yaw, double pitch) {
  return rotated_about(camera, yaw_and_pitch(camera, up, -yaw, pitch), camera.position());
}

Camera stepped(const Camera& camera, glm::dvec3 step) {
  Camera result = camera;
  result.view_from_world[3] -= step;
  return result;
}

glm::dvec3 pan_step(const Camera& camera, double depth, glm::dvec2 pixels) {
  return {-pixels * depth / camera.focal_px, 0};
}

Camera rolled(const Camera& camera, double angle) {
  return rotated_about(camera, turn(view_axes(camera).forward, angle), camera.position());
}

double vertical_fov(const Camera& camera) {
  return 2 * std::atan(0.5 * camera.height / camera.focal_px.y);
}

Camera with_vertical_fov(const Camera& camera, double fov) {
  const double kept = std::clamp(fov, glm::radians(0.5), glm::radians(170.0));
  Camera result = camera;
  result.focal_px *= std::tan(0.5 * vertical_fov(camera)) / std::tan(0.5 * kept);
  return result;
}

double depth_of(const Camera& camera, glm::dvec3 point) {
  return glm::dot(view_axes(camera).forward, point - camera.position());
}

glm::dvec3 point_at(const Camera& camera, glm::dvec2 pixel, double depth) {
  const glm::dvec3 view(depth * (pixel - camera.center_px) / camera.focal_px, depth);
  return camera.position() + glm::transpose(glm::dmat3(camera.view_from_world)) * view;
}

}  // namespace qs
