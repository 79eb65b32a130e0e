// SPDX-License-Identifier: MIT
//
// Exact occlusion for crowded views. A frame is drawn in slabs of depth, front to back. A Gaussian
// whose pixels have all stopped behind the slabs in front is neither coloured nor listed, and a
// block of Gaussians is skipped unread.
#pragma once

#include "raster/cuda/fast/column.cuh"
#include "raster/cuda/fast/macro_tiles.cuh"
#include "raster/kernel/frustum.h"

namespace qs::cuda::fast {

/// Pixels x0..x1 and y0..y1, both included.
struct PixelRect {
  int x0, y0, x1, y1;

  /// The pixels of a picture within `half` of the mean; all pixels if it is not a number.
  __device__ PixelRect(glm::vec2 mean, glm::vec2 half, int width, int height)
      : x0(static_cast<int>(fmaxf(ceilf(mean.x - half.x), 0.0f))),
        y0(static_cast<int>(fmaxf(ceilf(mean.y - half.y), 0.0f))),
        x1(static_cast<int>(fminf(floorf(mean.x + half.x), static_cast<float>(width - 1)))),
        y1(static_cast<int>(fminf(floorf(mean.y + half.y), static_cast<float>(height - 1)))) {}

  __device__ bool is_empty() const { return x0 > x1 || y0 > y1; }
};

/// The progress of a frame that is drawn in slabs. A kernel parameter; without slabs the pointers
/// are null.
struct OcclusionView {
  static constexpr unsigned kMostSlabs = 16;
  static constexpr int kWidth = kSubWidth, kHeight = kSubHeight;  ///< of a cell, px
  static constexpr int kCells = 8;  ///< per row and column of a macro-tile
  static constexpr unsigned kBins = 4096, kBinShift = 16;
  static_assert(kCells * kWidth == MacroTiles::kColumns * kTileSize);
  static_assert(kCells * kHeight == MacroTiles::kRows * kTileSize);

  std::uint32_t* borders;    ///< depth key at which each slab begins, and the end
  std::uint32_t* histogram;  ///< per bin of depth keys: blocks that are shown
  float2* depths;            ///< per block of Gaussians: its nearest and farthest
  /// Per macro-tile: the cells whose pixels have all stopped; bit kCells * row + column.
  unsigned long long* stopped;
  float* transmittance;  ///< per pixel, scaled as in ColumnPixel
  int columns;           ///< of macro-tiles
  int width, height;     ///< px
  unsigned slab;

  QS_HD bool is_used() const { return borders != nullptr; }

  __device__ bool holds(std::uint32_t key) const {
    return key >= borders[slab] && key < borders[slab + 1];
  }

  /// True if no pixel of `rect` goes on.
  __device__ bool hides(const PixelRect& rect) const {
    constexpr int kMostWords = 64;
    if (rect.is_empty()) return true;
    const int left = rect.x0 / kWidth, right = rect.x1 / kWidth;
    const int top = rect.y0 / kHeight, bottom = rect.y1 / kHeight;
    const int first_column = left / kCells, last_column = right / kCells;
    const int first_row = top / kCells, last_row = bottom / kCells;
    if ((last_column - first_column + 1) * (last_row - first_row + 1) > kMostWords) return false;
    for (int row = first_row; row <= last_row; ++row) {
      const int y0 = max(top - row * kCells, 0), y1 = min(bottom - row * kCells, kCells - 1);
      const unsigned long long rows = ~0ull >> (8 * (kCells - 1 - y1)) & ~0ull << (8 * y0);
      for (int column = first_column; column <= last_column; ++column) {
        const int x0 = max(left - column * kCells, 0);
        const int x1 = min(right - column * kCells, kCells - 1);
        const unsigned bits = 0xffu >> (kCells - 1 - x1) & 0xffu << x0;
        const unsigned long long cells = 0x0101010101010101ull * bits & rows;
        if ((stopped[row * columns + column] & cells) != cells) return false;
      }
    }
    return true;
  }

  /// The transmittance of a pixel in front of the slab; 0: it has stopped, or is not in the
  /// picture.
  __device__ float carried(int x, int y) const {
    if (x >= width || y >= height) return 0;
    return slab > 0 ? transmittance[static_cast<std::size_t>(y) * width + x] : kClear<Cut::flush>;
  }

  /// The lanes of a warp, which draw half a tile, say if their pixels go on. `x0` and `y0`: its
  /// first pixel.
  __device__ void record(int x0, int y0, bool is_live) const {
    const unsigned lanes = __ballot_sync(kAllLanes, is_live);
    unsigned long long cells = 0;
#pragma unroll
    for (unsigned s = 0; s < kSubTiles; ++s) {
      const bool stops = (lanes >> (s * kLanes) & ((1u << kLanes) - 1)) == 0;
      const int column = x0 / kWidth % kCells + static_cast<int>(s) % 2;
      const int row = y0 / kHeight % kCells + static_cast<int>(s) / 2;
      if (stops) cells |= 1ull << (kCells * row + column);
    }
    const int word = y0 / kHeight / kCells * columns + x0 / kWidth / kCells;
    if (lane_index() == 0 && cells != 0) atomicOr(&stopped[word], cells);
  }
};

}  // namespace qs::cuda::fast
