// SPDX-License-Identifier: MIT
#include "app/viewer/state/changes.h"

#include <algorithm>
#include <limits>

#include <glm/geometric.hpp>

#include "app/session/camera_control.h"
#include "app/session/framing.h"

namespace qs {
namespace {

constexpr double kToastSeconds = 5, kErrorSeconds = 12;

int nearest_camera(const Viewer& viewer) {
  int nearest = -1;
  double best = std::numeric_limits<double>::infinity();
  const ViewAxes here = view_axes(viewer.camera);
  for (std::size_t i = 0; i < viewer.scene->cameras.size(); ++i) {
    const Camera& other = viewer.scene->cameras[i];
    // A camera that looks elsewhere is farther: half a turn counts as one extent.
    const double apart = glm::distance(other.position(), viewer.camera.position());
    const double turned = 0.5 * (1 - glm::dot(here.forward, view_axes(other).forward));
    const double distance = apart + turned * viewer.scene->extent();
    if (distance < best) best = distance, nearest = static_cast<int>(i);
  }
  return nearest;
}

}  // namespace

void picture_changed(Viewer& viewer) { ++viewer.version; }

void view_changed(Viewer& viewer) {
  ++viewer.version;
  ++viewer.view_version;
}

void say(Viewer& viewer, std::string text, bool error) {
  viewer.toasts.push_back(
      {std::move(text), error, viewer.now + (error ? kErrorSeconds : kToastSeconds)});
}

void request_now(Viewer& viewer, Request request) { viewer.requests.push_back(std::move(request)); }

void set_view(Viewer& viewer, const Camera& camera) {
  viewer.camera =
      viewer.camera.width > 0 ? camera.resized(viewer.camera.width, viewer.camera.height) : camera;
  view_changed(viewer);
}

void move(Viewer& viewer, const Camera& camera) {
  viewer.camera = camera;
  viewer.dataset_camera = -1;
  viewer.last_motion = viewer.now;
  view_changed(viewer);
}

glm::dvec3 natural_pivot(const Camera& camera, const ViewedScene& scene) {
  const double least = 0.05 * scene.extent();
  const double depth = std::max(depth_of(camera, glm::dvec3(scene.core.center())), least);
  return camera.position() + depth * view_axes(camera).forward;
}

double pivot_depth(const Viewer& viewer) {
  const double least = viewer.scene ? 1e-3 * viewer.scene->extent() : 1e-3;
  return std::max(depth_of(viewer.camera, viewer.pivot), least);
}

Camera framed(const Viewer& viewer) {
  const ViewedScene& scene = *viewer.scene;
  const int width = std::max(viewer.camera.width, 1), height = std::max(viewer.camera.height, 1);
  return frame_box(scene.core, scene.smallest_radius, scene.up, width, height);
}

void read_photograph(Viewer& viewer) {
  if (!viewer.panels.photograph || viewer.dataset_camera < 0) return;
  const auto found = viewer.scene->photographs.find(viewer.dataset_camera);
  if (found != viewer.scene->photographs.end())
    request_now(viewer, request::ReadPhotograph{found->second});
}

void go_to_camera(Viewer& viewer, int index) {
  const std::vector<Camera>& cameras = viewer.scene->cameras;
  if (index < 0 || index >= static_cast<int>(cameras.size())) return;
  const Camera& camera = cameras[static_cast<std::size_t>(index)];
  set_view(viewer, camera);
  viewer.pivot = natural_pivot(viewer.camera, *viewer.scene);
  viewer.dataset_camera = index;
  read_photograph(viewer);
}

void step_camera(Viewer& viewer, action::CameraStep step) {
  if (!viewer.scene || viewer.scene->cameras.empty()) {
    return say(viewer, "this scene has no cameras: drop its cameras.json on the window");
  }
  const int count = static_cast<int>(viewer.scene->cameras.size());
  const int at = viewer.dataset_camera < 0 ? nearest_camera(viewer) : viewer.dataset_camera;
  switch (step) {
    case action::CameraStep::previous:
      return go_to_camera(viewer, (at + count - 1) % count);
    case action::CameraStep::next:
      return go_to_camera(viewer, (at + 1) % count);
    case action::CameraStep::first:
      return go_to_camera(viewer, 0);
    case action::CameraStep::last:
      return go_to_camera(viewer, count - 1);
    case action::CameraStep::nearest:
      return go_to_camera(viewer, nearest_camera(viewer));
  }
}

void set_first_view(Viewer& viewer) {
  viewer.home = framed(viewer);
  viewer.dataset_camera = -1;
  if (!viewer.scene->cameras.empty()) {
    go_to_camera(viewer, 0);
    viewer.home = viewer.camera;
    return;
  }
  set_view(viewer, viewer.home);
  viewer.pivot = glm::dvec3(viewer.scene->core.center());
}

}  // namespace qs
