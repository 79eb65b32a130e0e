// SPDX-License-Identifier: MIT
//
// The cameras of a scene, where the scene is: their places count from GaussianCloud::origin.
// Cameras of another frame, such as a normalised export's, see nothing of it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/scene/reader.h"
#include "raster/scene/camera.h"

namespace qs {

struct PlacedCameras {
  std::vector<Camera> cameras;
  std::vector<std::string> warnings;  ///< sentences
};

/// The cameras of a file, moved to the scene's origin. Cameras that see nothing of the scene get a
/// warning, and are left out unless the user named the file. Throws Error(input).
PlacedCameras placed_cameras(const std::filesystem::path& file, const Scene& scene, bool is_named);

/// True if a picture of a camera shows a part of one of the Gaussians within three standard
/// deviations. Looks at most at some thousand cameras, at equal distances in their order.
bool sees_scene(const std::vector<Camera>& cameras, const GaussianCloud& cloud);

}  // namespace qs
