// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/tile.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/tile.cpp"
#include "base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Writes the colours of `count` pixels of one row of a cell, from pixel `from`.
HWY_INLINE void write_pixels(const Cell& cell, int from, int count, float* color) {
  const hn::CappedTag<float, kCellSide> d;
  if (count == kCellSide) {
    for (int i = from; i < from + count; i += static_cast<int>(hn::Lanes(d))) {
      hn::StoreInterleaved3(hn::LoadU(d, cell.red + i), hn::LoadU(d, cell.green + i),
                            hn::LoadU(d, cell.blue + i), d, color + 3 * (i - from));
    }
    return;
  }
  for (int i = from; i < from + count; ++i, color += 3) {
    color[0] = cell.red[i];
    color[1] = cell.green[i];
    color[2] = cell.blue[i];
  }
}

void write_tile(const Tile& tile, const TileJob& job) {
  for (int row = 0; row < job.height; ++row) {
    const std::size_t begin = static_cast<std::size_t>(row) * job.stride;
    for (int column = 0; column < job.width; column += kCellSide) {
      const int count = std::min(kCellSide, job.width - column);
      const int cell = Tile::cell_of(column, row), from = Tile::pixel_of(column, row);
      const std::size_t to = begin + static_cast<std::size_t>(column);
      if (job.color != nullptr) write_pixels(tile.cells[cell], from, count, job.color + 3 * to);
      if (job.evaluated != nullptr)
        std::copy_n(tile.evaluated[cell] + from, count, job.evaluated + to);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(write_tile);

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

void Tile::write(const TileJob& job) const { HWY_DYNAMIC_DISPATCH(write_tile)(*this, job); }

}  // namespace qs::cpu::fast
#endif
