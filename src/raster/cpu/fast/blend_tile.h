// SPDX-License-Identifier: MIT
//
// One tile of blend: kernel/blend.h's rules for a cell of 4x4 pixels at a time.
#pragma once

#include <cstdint>

#include "raster/cpu/fast/preprocess.h"

namespace qs::cpu::fast {

struct TileJob {
  const std::uint32_t* list;  ///< slots front to back
  std::uint32_t length;
  const Record* records;  ///< per slot
  int x0, y0;             ///< of the tile's first pixel
  int width, height;      ///< pixels of the tile inside the picture
  glm::vec3 background;
  float* color;              ///< RGB of the tile's first pixel; null = not wanted
  std::uint32_t* evaluated;  ///< of the tile's first pixel; null = not wanted
  std::size_t stride;        ///< pixels from one row of the picture to the next
};

void blend_tile(const TileJob& job);

}  // namespace qs::cpu::fast
