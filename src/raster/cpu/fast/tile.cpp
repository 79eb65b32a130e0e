// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/tile.h"

#include <algorithm>
#include <cmath>

namespace qs::cpu::fast {
namespace {

bool finished(const Cell& cell) {
  return std::all_of(cell.log2_alpha_min, cell.log2_alpha_min + kCellPixels,
                     [](float least) { return least == INFINITY; });
}

}  // namespace

Tile::Tile(const TileJob& job) {
  for (int row = 0; row < kTileSize; ++row) {
    for (int column = 0; column < kTileSize; ++column) {
      Cell& cell = cells[cell_of(column, row)];
      const int i = pixel_of(column, row);
      const bool inside = column < job.width && row < job.height;
      cell.transmittance[i] = 1;
      cell.red[i] = cell.green[i] = cell.blue[i] = 0;
      cell.log2_alpha_min[i] = inside ? -kLog2Of255 : INFINITY;
      cell.x[i] = static_cast<float>(job.x0 + column);
      cell.y[i] = static_cast<float>(job.y0 + row);
    }
  }
  for (std::uint32_t cell = 0; cell < kCells; ++cell) {
    cell_x[cell] = cells[cell].x[0];
    cell_y[cell] = cells[cell].y[0];
    numbers[cell] = cell;
    std::fill_n(evaluated[cell], kCellPixels, job.length);
  }
  close_finished_cells();
}

void Tile::close_finished_cells() {
  live = false;
  for (int cell = 0; cell < kCells; ++cell) {
    closed[cell] = finished(cells[cell]) ? INFINITY : 0.0f;
    live = live || closed[cell] == 0.0f;
  }
}

void Tile::write(const TileJob& job) const {
  for (int row = 0; row < job.height; ++row) {
    for (int column = 0; column < job.width; ++column) {
      const Cell& cell = cells[cell_of(column, row)];
      const int i = pixel_of(column, row);
      const std::size_t to =
          static_cast<std::size_t>(row) * job.stride + static_cast<std::size_t>(column);
      if (job.color != nullptr) {
        job.color[3 * to] = cell.red[i] + cell.transmittance[i] * job.background.x;
        job.color[3 * to + 1] = cell.green[i] + cell.transmittance[i] * job.background.y;
        job.color[3 * to + 2] = cell.blue[i] + cell.transmittance[i] * job.background.z;
      }
      if (job.evaluated != nullptr) job.evaluated[to] = evaluated[cell_of(column, row)][i];
    }
  }
}

}  // namespace qs::cpu::fast
