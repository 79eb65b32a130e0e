// SPDX-License-Identifier: MIT
//
// A tile of the picture while blend composites it: pixels in the order in which vectors take them.
#pragma once

#include "raster/cpu/fast/blend_tile.h"
#include "raster/kernel/constants.h"

namespace qs::cpu::fast {

/// Tiles are cut into cells, because most Gaussians reach only a part of a tile.
constexpr int kCellSide = 4;
constexpr int kCellPixels = kCellSide * kCellSide;
constexpr int kCellsInRow = kTileSize / kCellSide;
constexpr int kCells = kCellsInRow * kCellsInRow;

/// Pixels that are composited together, row by row. A plane per value; the planes of a cell lie
/// side by side, at distances that keep stores to one from holding up loads of another.
struct alignas(64) Cell {
  float transmittance[kCellPixels];
  float red[kCellPixels], green[kCellPixels], blue[kCellPixels];
  float log2_alpha_min[kCellPixels];     ///< what counts: 1/255 until the pixel stops, then inf
  float x[kCellPixels], y[kCellPixels];  ///< in the picture
};

/// A tile while it is composited.
struct Tile {
  Cell cells[kCells];
  alignas(64) float cell_x[kCells];           ///< of the first pixel of the cell
  alignas(64) float cell_y[kCells];           ///< of the first pixel of the cell
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

  /// To be called when pixels have stopped.
  void close_finished_cells();

  void write(const TileJob& job) const;
};

}  // namespace qs::cpu::fast
