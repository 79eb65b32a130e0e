// SPDX-License-Identifier: MIT
#include "app/session/placed_cameras.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/framing/scene_box.h"
#include "io/camera/cameras.h"

namespace qs {

PlacedCameras placed_cameras(const std::filesystem::path& file, const Scene& scene) {
  const CameraSet set = read_camera_set(file);
  PlacedCameras placed{pinhole_cameras(set.cameras), set.sentences()};
  for (Camera& camera : placed.cameras) camera = camera.placed(scene.cloud.origin);
  return placed;
}

bool sees_scene(const std::vector<Camera>& cameras, const GaussianCloud& cloud) {
  constexpr std::size_t kMostCameras = 1000, kMostGaussians = 20'000;
  constexpr double kReach = 3;  // standard deviations
  const std::size_t camera_step = 1 + cameras.size() / kMostCameras;
  const std::size_t step = 1 + cloud.size() / kMostGaussians;
  for (std::size_t c = 0; c < cameras.size(); c += camera_step) {
    const Camera& camera = cameras[c];
    for (std::size_t i = 0; i < cloud.size(); i += step) {
      const glm::dvec3 at = camera.view_from_world * glm::dvec4(cloud.positions[i], 1);
      if (at.z <= camera.near_depth) continue;
      const glm::dvec2 pixel = camera.focal_px * glm::dvec2(at) / at.z + camera.center_px;
      const auto size = std::exp(static_cast<double>(largest_of(cloud.log_scales[i])));
      const glm::dvec2 reach = kReach * size * camera.focal_px / at.z;
      if (pixel.x + reach.x >= 0 && pixel.x - reach.x <= camera.width - 1 &&
          pixel.y + reach.y >= 0 && pixel.y - reach.y <= camera.height - 1)
        return true;
    }
  }
  return false;
}

std::string blind_cameras_text(const std::filesystem::path& file) {
  return fmt::format(
      "{}: none of its cameras sees a Gaussian: they belong to another frame or another scene",
      file.string());
}

}  // namespace qs
