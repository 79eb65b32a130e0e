// SPDX-License-Identifier: MIT
//
// Frames are named by the directions of x, y and z: Left or Right, Down or Up, Back or Forward.
// SPZ's RUB has x right, y up, z back; the cloud's RDF x right, y down, z forward; RFU has z up.
// flip_axes() converts between frames with parallel axes: position, rotation and SH together.
// Flipping one sign mirrors the scene; the formulas still hold, because a Gaussian's covariance has
// no handedness.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include <glm/mat3x3.hpp>

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

/// Frames with axes parallel to the cloud's, in the order of SPZ's coordinate system extension,
/// which counts from 1.
inline constexpr std::array<std::string_view, 8> kAxes = {"LDB", "RDB", "LUB", "RUB",
                                                          "LDF", "RDF", "LUF", "RUF"};

/// Signs that turn frame kAxes[number] into RDF, and back.
constexpr AxisSigns signs_to_rdf(std::size_t number) {
  return {(number & 1) != 0 ? 1.0f : -1.0f, (number & 2) != 0 ? -1.0f : 1.0f,
          (number & 4) != 0 ? 1.0f : -1.0f};
}

/// True if `name` is in kAxes or another right-handed frame, 28 names in all.
bool is_axes(std::string_view name);

/// The name after half a turn about the axis from left to right: up and down are exchanged, and so
/// are back and forward.
std::string turned_over(std::string_view name);

/// Turns vectors of the frame into RDF. is_axes(name) must hold.
glm::dmat3 rdf_from(std::string_view name);

/// Applies `signs` to the Gaussians [begin, end). Applying them twice changes nothing.
void flip_axes(GaussianCloud& cloud, std::size_t begin, std::size_t end, AxisSigns signs);

}  // namespace qs
