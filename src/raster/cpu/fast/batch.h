// SPDX-License-Identifier: MIT
//
// A part of a tile's list, prepared for compositing.
#pragma once

#include "raster/cpu/fast/tile.h"

namespace qs::cpu::fast {

inline constexpr float kLog2Of256AlphaMax = 8 - 0.014499570f;

struct alignas(64) Batch {
  static constexpr std::uint32_t kEntries = 128;
  static constexpr std::uint32_t kVector = 16;   ///< most lanes of a vector: room for whole stores
  static constexpr std::uint32_t kMultiple = 4;  ///< a cell's entries are a multiple of it
  static constexpr std::uint32_t kNone = kEntries;  ///< an entry that has no alpha anywhere

  /// The part that depends on the column of pixels: log2 of 256 alpha is
  /// level - (scale Y - offset)^2 in the row Y below the tile's middle.
  struct alignas(64) Columns {
    float level[kTileSize], offset[kTileSize];
  };
  struct alignas(16) Factors {
    float scale;
    float red, green, blue;  ///< without the background
  };
  Columns columns[kEntries + 1];  ///< per entry
  Factors factors[kEntries + 1];  ///< per entry

  /// Per cell: the entries that may have a pixel with alpha >= 1/255 in it, front to back, and
  /// kNone up to a multiple of kMultiple.
  std::uint32_t reaching[kCells][kEntries + kVector];
  std::uint32_t counts[kCells];
  bool limited;  ///< true if an entry may have an alpha above kAlphaMax

  Batch();

  /// Loads entries [first, first + size) of the list. Skips closed cells.
  void load(const TileJob& job, std::uint32_t first, std::uint32_t size, const bool* open);
};

}  // namespace qs::cpu::fast
