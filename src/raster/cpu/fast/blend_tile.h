// SPDX-License-Identifier: MIT
//
// Composites one tile with the rules of kernel/blend.h, a cell of 4x4 pixels at a time.
#pragma once

#include <cstdint>

#include "raster/cpu/fast/preprocess.h"

namespace qs::cpu::fast {

struct TileJob {
  const std::uint32_t* list;  ///< slots front to back
  std::uint32_t length;
  const Record* records;  ///< per slot
  int x0, y0;             ///< the tile's first pixel
  int width, height;      ///< width and height of the part inside the image, in pixels
  glm::vec3 background;
  float* color;              ///< at the tile's first pixel; null = not requested
  std::uint32_t* evaluated;  ///< at the tile's first pixel; null = not requested
  std::size_t stride;        ///< pixels per row of the image
};

void blend_tile(const TileJob& job);

}  // namespace qs::cpu::fast
