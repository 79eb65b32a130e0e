// SPDX-License-Identifier: MIT
//
// The distance of the scene in front of a camera, estimated from a fixed sample without rendering.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// A Gaussian of the sample. It represents several Gaussians of the cloud.
struct Landmark {
  glm::vec3 position{0.0f};
  /// Integral of their opacities, seen from their broadest side; world units squared.
  float area = 0;
};

/// At most `most` Gaussians at equal distances in the order of the cloud. Leaves out Gaussians
/// without a finite position or area.
std::vector<Landmark> landmarks_of(const GaussianCloud& cloud, std::size_t most = 4096);

/// The distance of the picture's content, world units. The picture has 8 x 8 parts. The depth of a
/// part is the depth up to which half of its light originates. The result is the median of these
/// depths. Empty parts do not count; unset if all are empty.
std::optional<double> depth_ahead(const Camera& camera, std::span<const Landmark> landmarks);

}  // namespace qs
