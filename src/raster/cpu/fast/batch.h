// SPDX-License-Identifier: MIT
//
// A part of a tile's list, prepared for compositing.
#pragma once

#include "raster/cpu/fast/tile.h"

namespace qs::cpu::fast {

struct alignas(64) Batch {
  static constexpr std::uint32_t kEntries = 128;
  static constexpr std::uint32_t kVector = 16;   ///< most lanes of a vector: room for whole stores
  static constexpr std::uint32_t kMultiple = 4;  ///< of the entries of a cell
  static constexpr std::uint32_t kNone = kEntries;  ///< an entry that has no alpha anywhere
  static constexpr std::uint32_t kRoom = kEntries + kVector;

  /// Per entry: log2 alpha is constant + x X + y Y + xx X^2 + xy X Y + yy Y^2, at X, Y from the
  /// tile's middle.
  float constant[kRoom], x[kRoom], y[kRoom], xx[kRoom], xy[kRoom], yy[kRoom];
  float limit[kRoom];                           ///< Record::limit
  float red[kRoom], green[kRoom], blue[kRoom];  ///< without the background

  /// Per cell: the entries that may have a pixel with alpha >= 1/255 in it, front to back, and
  /// kNone up to a multiple of kMultiple.
  std::uint32_t reaching[kCells][kRoom];
  std::uint32_t counts[kCells];
  bool limited;  ///< true if an entry has a finite limit

  Batch();

  /// Loads entries [first, first + size) of the list. Skips closed cells.
  void load(const TileJob& job, std::uint32_t first, std::uint32_t size, const bool* open);
};

}  // namespace qs::cpu::fast
