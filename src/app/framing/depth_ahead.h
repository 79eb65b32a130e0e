// SPDX-License-Identifier: MIT
//
// How far away is what a view shows, estimated from a fixed sample of the scene without rendering.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// A Gaussian of the sample and those of the cloud that it stands for.
struct Landmark {
  glm::vec3 position{0.0f};
  float area =
      0;  ///< integral of their opacities seen from their broadest side, world units squared
};

/// At most `most` Gaussians at equal distances in the order of the cloud. Leaves out those without
/// a finite position or area.
std::vector<Landmark> landmarks_of(const GaussianCloud& cloud, std::size_t most = 4096);

/// How far away the picture's content is, world units. The picture has 8 x 8 parts, and each has a
/// depth: half of its light comes from what is nearer. The result is the median of these depths.
/// Empty parts do not count; unset if all are empty.
std::optional<double> depth_ahead(const Camera& camera, std::span<const Landmark> landmarks);

}  // namespace qs
