// SPDX-License-Identifier: MIT
//
// What two frames of one view have different: their pixels, as a display shows them, and the pairs
// of their tiles.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "raster/renderer.h"

namespace qs {

struct PixelDifference {
  double psnr = std::numeric_limits<double>::infinity();  ///< dB over all RGB values, peak 255
  int largest = 0;                                        ///< of an 8-bit value
  glm::ivec2 farthest{-1};   ///< the first pixel, row by row, with it; (-1, -1) when equal
  std::uint64_t pixels = 0;  ///< that differ at all
};

/// Both are RGBA, 8 bits each, rows of `width` pixels from the top; only pixels of `box` count.
PixelDifference pixel_difference(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b,
                                 int width, const PixelBox& box);

struct PairDifference {
  TileGrid grid;
  std::vector<std::int32_t> values;  ///< per tile: pairs of the first less those of the second
  std::int64_t total = 0;
};

/// Of two maps Frame::pairs on the same grid.
PairDifference pair_difference(const TileGrid& grid, std::span<const std::uint32_t> a,
                               std::span<const std::uint32_t> b);

}  // namespace qs
