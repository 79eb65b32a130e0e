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

/// The median over 8 x 8 parts of the picture of the depth that half of the part's light comes
/// from, world units. Parts in which nothing is do not count; unset if nothing is in the picture.
std::optional<double> depth_ahead(const Camera& camera, std::span<const Landmark> landmarks);

}  // namespace qs
