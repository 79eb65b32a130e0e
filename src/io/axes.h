// SPDX-License-Identifier: MIT
//
// Moves Gaussians between frames whose axes are parallel, such as SPZ's RUB (x right, y up, z back)
// and the cloud's RDF: position, rotation and SH together. A change of one sign mirrors the scene;
// the formulas hold for that as well, because a Gaussian's covariance has no handedness.
#pragma once

#include <cstddef>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// +1 or -1 per axis: what a coordinate is multiplied with.
struct AxisSigns {
  float x = 1, y = 1, z = 1;

  bool is_identity() const { return x > 0 && y > 0 && z > 0; }
};

/// The 180-degree turn about x: RUB to RDF and back.
constexpr AxisSigns kTurnAboutX{1, -1, -1};
/// The 180-degree turn about z: glTF's LUF to RDF and back.
constexpr AxisSigns kTurnAboutZ{-1, -1, 1};

/// Applies `signs` to the Gaussians [begin, end). Applying them twice changes nothing.
void flip_axes(GaussianCloud& cloud, std::size_t begin, std::size_t end, AxisSigns signs);

}  // namespace qs
