// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "app/framing/camera_control.h"
#include "app/framing/first_view.h"
#include "app/framing/scene_box.h"
#include "app/framing/up_axis.h"

namespace qs {
glm::dvec3 cameras_up(const std::vector<Camera>& cameras, glm::dvec3 otherwise) {
  const auto count = static_cast<double>(cameras.size());
  glm::dvec3 sum(0);
  glm::dmat3 rights(0);
  for (const Camera& camera : cameras) {
    const ViewAxes axes = view_axes(camera);
    sum -= axes.down;
    rights += glm::outerProduct(axes.right, axes.right);
  }
  const double length = glm::length(sum);
  if (!(length > 0.1 * count)) return otherwise;
  const glm::dvec3 mean = sum / length;
  const PrincipalAxes axes = principal_axes(rights);
  const double side = glm::dot(axes.axis[0], mean);
  const bool determined = axes.value[0] < 0.1 * axes.value[1] && axes.value[1] > 0.005 * count;
  if (!determined || std::abs(side) < 0.5) return mean;
  return side < 0 ? -axes.axis[0] : axes.axis[0];
}

std::optional<glm::dvec3> cameras_target(const std::vector<Camera>& cameras) {
  glm::dmat3 across(0);
  glm::dvec3 sum(0);
  for (const Camera& camera : cameras) {
    const glm::dvec3 forward = view_axes(camera).forward;
    const glm::dmat3 one = glm::dmat3(1.0) - glm::outerProduct(forward, forward);
    across += one;
    sum += one * camera.position();
  }
  const PrincipalAxes axes = principal_axes(across);
  if (cameras.empty() || !(axes.value[0] > 0.002 * axes.value[2])) return {};
  const glm::dvec3 target = glm::inverse(across) * sum;
  const auto ahead = std::ranges::count_if(
      cameras, [&](const Camera& camera) { return depth_of(camera, target) > 0; });
  if (2 * ahead < static_cast<std::ptrdiff_t>(cameras.size())) return {};
  return target;
}

std::optional<Framing> framing_of(const std::vector<Camera>& cameras, glm::dvec3 up) {
  if (cameras.empty()) return {};
  glm::dvec3 middle(0);
  for (const Camera& camera : cameras)
    middle += camera.position() / static_cast<double>(cameras.size());
  const std::optional<glm::dvec3> target = cameras_target(cameras);
  std::vector<double> distances;
  for (const Camera& camera : cameras)
    distances.push_back(glm::distance(camera.position(), target.value_or(middle)));
  const double usual = upper_median(std::move(distances));  // distance of a camera
  // With a target: the camera that looks straightest at it from about the usual distance. Without a
  // target: the camera nearest to the middle of all cameras.
  std::optional<Framing> best;
  double least = 0;
  for (const Camera& camera : cameras) {
    const glm::dvec3 eye = camera.position(), forward = view_axes(camera).forward;
    const glm::dvec3 seen = target ? *target : eye + std::max(usual, 1e-3) * forward;
    const double distance = glm::distance(seen, eye);
    if (!(distance > 1e-3 * usual) || std::abs(glm::dot(seen - eye, up)) > 0.98 * distance)
      continue;
    const double straight = glm::dot(forward, seen - eye) / distance;
    const double cost = target ? std::abs(std::log(distance / usual)) + 2 * (1 - straight)
                               : glm::distance(eye, middle);
    if (best && cost >= least) continue;
    least = cost;
    best = Framing{eye, seen, up, vertical_fov(camera), 0, 1, camera.near_depth};
  }
  return best;
}

Framing subject_framing(const std::vector<Camera>& cameras, const std::optional<glm::dvec3>& up,
                        const std::function<Framing()>& choose) {
  const glm::dvec3 upward = up.value_or(cameras_up(cameras, world_up("")));
  const std::optional<Framing> framing = framing_of(cameras, upward);
  return framing ? *framing : choose();
}

}  // namespace qs
