// SPDX-License-Identifier: MIT
//
// The pixels of a tile while it is composited, in the order of the vector code.
#pragma once

#include "raster/cpu/fast/blend_tile.h"
#include "raster/kernel/constants.h"

namespace qs::cpu::fast {

/// Tiles consist of cells, because most Gaussians reach only a part of a tile.
constexpr int kCellSide = 4;
constexpr int kCellPixels = kCellSide * kCellSide;
constexpr int kCellsInRow = kTileSize / kCellSide;
constexpr int kCells = kCellsInRow * kCellsInRow;

/// Pixels composited together, row by row, stored as one array per value.
struct alignas(64) Cell {
  /// 0: the pixel has stopped or lies outside of the image. Otherwise >= kTransmittanceMin.
  float transmittance[kCellPixels];
  /// The colours begin with the background, which the composited colours do not contain. So the
  /// transmittance is needed only to decide when a pixel stops.
  float red[kCellPixels], green[kCellPixels], blue[kCellPixels];
};

struct Tile {
  Cell cells[kCells];
  bool open[kCells];  ///< true if the cell may have live pixels
  alignas(64) std::uint32_t evaluated[kCells][kCellPixels];  ///< list entries up to the stop

  static int cell_of(int column, int row) {
    return row / kCellSide * kCellsInRow + column / kCellSide;
  }
  static int pixel_of(int column, int row) {
    return row % kCellSide * kCellSide + column % kCellSide;
  }

  explicit Tile(const TileJob& job);

  /// True if a cell is open.
  bool live() const;
  void write(const TileJob& job) const;
};

}  // namespace qs::cpu::fast
