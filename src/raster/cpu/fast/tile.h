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

/// Pixels composited together, row by row, stored as one array per value. The arrays of a cell are
/// adjacent, so that a store to one does not alias a load from another (4 KB aliasing).
struct alignas(64) Cell {
  float transmittance[kCellPixels];
  float red[kCellPixels], green[kCellPixels], blue[kCellPixels];
  float log2_alpha_min[kCellPixels];     ///< log2(1/255) until the pixel stops, then inf
  float x[kCellPixels], y[kCellPixels];  ///< in the image
};

struct Tile {
  Cell cells[kCells];
  alignas(64) float cell_x[kCells];           ///< the first pixel of the cell
  alignas(64) float cell_y[kCells];           ///< the first pixel of the cell
  alignas(64) float closed[kCells];           ///< 0 while the cell has live pixels, then inf
  alignas(64) std::uint32_t numbers[kCells];  ///< 0, 1, 2, ...
  alignas(64) std::uint32_t evaluated[kCells][kCellPixels];  ///< list entries up to the stop
  bool live = true;

  static int cell_of(int column, int row) {
    return row / kCellSide * kCellsInRow + column / kCellSide;
  }
  static int pixel_of(int column, int row) {
    return row % kCellSide * kCellSide + column % kCellSide;
  }

  explicit Tile(const TileJob& job);

  /// Call it after pixels have stopped.
  void close_finished_cells();

  void write(const TileJob& job) const;
};

}  // namespace qs::cpu::fast
