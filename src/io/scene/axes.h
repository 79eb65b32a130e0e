// SPDX-License-Identifier: MIT
//
// Converts Gaussians between frames with parallel axes, such as SPZ's RUB (x right, y up, z back)
// and the cloud's RDF: position, rotation and SH together. Flipping one sign mirrors the scene; the
// formulas still hold, because a Gaussian's covariance has no handedness.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// One factor per axis, +1 or -1.
struct AxisSigns {
  float x = 1, y = 1, z = 1;

  bool is_identity() const { return x > 0 && y > 0 && z > 0; }
};

/// The 180-degree turn about x: RUB to RDF and back.
constexpr AxisSigns kTurnAboutX{1, -1, -1};
/// The 180-degree turn about z: glTF's LUF to RDF and back.
constexpr AxisSigns kTurnAboutZ{-1, -1, 1};

/// Frames with axes parallel to the cloud's. The letters say where x, y and z point: left or right,
/// down or up, back or forward. The order is that of SPZ's coordinate system extension, which
/// counts from 1.
inline constexpr std::array<std::string_view, 8> kAxes = {"LDB", "RDB", "LUB", "RUB",
                                                          "LDF", "RDF", "LUF", "RUF"};

/// Signs that turn frame kAxes[number] into RDF, and back.
constexpr AxisSigns signs_to_rdf(std::size_t number) {
  return {(number & 1) != 0 ? 1.0f : -1.0f, (number & 2) != 0 ? -1.0f : 1.0f,
          (number & 4) != 0 ? 1.0f : -1.0f};
}

/// Applies `signs` to the Gaussians [begin, end). Applying them twice changes nothing.
void flip_axes(GaussianCloud& cloud, std::size_t begin, std::size_t end, AxisSigns signs);

}  // namespace qs
