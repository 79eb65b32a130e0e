// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/tile.h"

#include <algorithm>

namespace qs::cpu::fast {

Tile::Tile(const TileJob& job) {
  for (Cell& cell : cells) {
    std::fill_n(cell.transmittance, kCellPixels, 1.0f);
    std::fill_n(cell.red, kCellPixels, job.background.x);
    std::fill_n(cell.green, kCellPixels, job.background.y);
    std::fill_n(cell.blue, kCellPixels, job.background.z);
  }
  std::fill_n(open, kCells, true);
  std::fill_n(evaluated[0], kCells * kCellPixels, job.length);
  if (job.width == kTileSize && job.height == kTileSize) return;
  std::fill_n(open, kCells, false);
  for (int row = 0; row < kTileSize; ++row) {
    for (int column = 0; column < kTileSize; ++column) {
      const int cell = cell_of(column, row);
      if (column < job.width && row < job.height) {
        open[cell] = true;
      } else {
        cells[cell].transmittance[pixel_of(column, row)] = 0;
      }
    }
  }
}

bool Tile::live() const {
  return std::any_of(open, open + kCells, [](bool cell) { return cell; });
}

void Tile::write(const TileJob& job) const {
  for (int row = 0; row < job.height; ++row) {
    const std::size_t begin = static_cast<std::size_t>(row) * job.stride;
    for (int column = 0; column < job.width; column += kCellSide) {
      const int in_cell = std::min(kCellSide, job.width - column);
      const Cell& cell = cells[cell_of(column, row)];
      const int from = pixel_of(column, row);
      const std::size_t to = begin + static_cast<std::size_t>(column);
      if (job.color != nullptr) {
        float* color = job.color + 3 * to;
        for (int i = from; i < from + in_cell; ++i, color += 3) {
          color[0] = cell.red[i];
          color[1] = cell.green[i];
          color[2] = cell.blue[i];
        }
      }
      if (job.evaluated != nullptr)
        std::copy_n(evaluated[cell_of(column, row)] + from, in_cell, job.evaluated + to);
    }
  }
}

}  // namespace qs::cpu::fast
