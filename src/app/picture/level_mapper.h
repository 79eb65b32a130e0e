// SPDX-License-Identifier: MIT
//
// Renderers that draw cuts of trees with levels of detail can say what the nodes of a cut are.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "raster/api/renderer.h"

namespace qs {

class LevelMapper {
 public:
  virtual ~LevelMapper() = default;

  /// Values per pixel, row by row; empty for scenes without levels. The levels of the nodes, each
  /// times its share of the pixel: 0 for a leaf, k for a node in the place of about 2^k leaves. Or
  /// `errors`: the root of the estimated squared error of a colour value, in steps of 1/255.
  /// Throws Error and Cancelled.
  virtual std::vector<std::uint32_t> level_map(const Camera& camera, const RenderSettings& settings,
                                               bool errors, std::stop_token stop) = 0;
};

}  // namespace qs
