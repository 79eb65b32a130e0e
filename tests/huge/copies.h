// SPDX-License-Identifier: MIT
//
// Copies of a scene on a plane, each with its own rotation, scale and tint.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "io/scene/instances.h"
#include "raster/scene/camera.h"

namespace qs {

struct Copies {
  std::vector<Instance> instances;
  std::vector<Camera>
      cameras;  ///< of 800 x 600 pixels: before the first copy, along a row, above all
};

/// `count` copies on a grid in the plane x, z. Each is turned about y by any angle and tilted by up
/// to 10 degrees, scaled by 0.7 to 1.3, and its colours are multiplied by 0.7 to 1.2.
Copies scatter_copies(const GaussianCloud& scene, std::size_t count, std::uint64_t seed);

}  // namespace qs
