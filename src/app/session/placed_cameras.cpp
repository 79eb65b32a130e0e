// SPDX-License-Identifier: MIT
#include "app/session/placed_cameras.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/framing/scene_box.h"
#include "io/camera/cameras.h"
#include "raster/scene/place.h"

namespace qs {

bool sees_scene(const std::vector<Camera>& cameras, const GaussianCloud& cloud) {
  constexpr std::size_t kMostCameras = 1000;
  constexpr double kReach = 3;  // standard deviations
  const std::size_t step = 1 + cameras.size() / kMostCameras;
  for (std::size_t c = 0; c < cameras.size(); c += step) {
    const bool sees = sees_any(cameras[c], cloud.size(), [&](std::size_t i) {
      const auto size = std::exp(static_cast<double>(largest_of(cloud.log_scales[i])));
      return glm::dvec4(cloud.positions[i], kReach * size);
    });
    if (sees) return true;
  }
  return false;
}

PlacedCameras placed_cameras(const std::filesystem::path& file, const Scene& scene, bool is_named) {
  const CameraSet set = read_camera_set(file);
  PlacedCameras placed{pinhole_cameras(set.cameras), set.sentences()};
  for (Camera& camera : placed.cameras) camera = camera.placed(scene.cloud.origin);
  const auto wide = std::ranges::count_if(set.cameras, [](const LensCamera& camera) {
    return camera.lens && camera.lens->face == kAllFaces;
  });
  if (wide > 0)
    placed.warnings.push_back(
        fmt::format("{}: {} of {} cameras have lenses too wide for a pinhole camera: their front "
                    "faces are used",
                    file.string(), wide, set.cameras.size()));
  if (placed.cameras.empty() || sees_scene(placed.cameras, scene.cloud)) return placed;
  placed.warnings.push_back(fmt::format(
      "{}: none of its cameras sees a Gaussian: they belong to another frame or another scene",
      file.string()));
  if (!is_named) placed.cameras.clear();
  return placed;
}

}  // namespace qs
