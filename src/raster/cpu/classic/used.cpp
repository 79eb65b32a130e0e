// SPDX-License-Identifier: MIT
#include "raster/cpu/classic/used.h"

#include <algorithm>
#include <array>

#include "raster/kernel/composite.h"

namespace qs::cpu {
namespace {

constexpr int kLargestTile = kTileSizes.back();

/// The pixels of a tile that are inside the image. Coordinates start at the tile's corner.
struct TilePixels {
  float x0, y0;             // the corner, in the image
  int width, height, live;  // live: pixels that have not stopped
  std::array<float, kLargestTile * kLargestTile> transmittance;  // row by row; 0 = stopped

  /// Composites a Gaussian. True if a pixel blends it.
  bool uses(const BoundedSplat& bounded) {
    const glm::vec2 half = bounded.bound.half, mean = bounded.splat.mean_px - glm::vec2(x0, y0);
    const Span columns{clamp_to_int(mean.x - half.x, width),
                       clamp_to_int(mean.x + half.x + 1, width)};
    const Span rows{clamp_to_int(mean.y - half.y, height),
                    clamp_to_int(mean.y + half.y + 1, height)};
    bool used = false;
    for (int y = rows.begin; y < rows.end; ++y) {
      for (int x = columns.begin; x < columns.end; ++x) {
        float& left = transmittance[static_cast<std::size_t>(y * width + x)];
        if (left == 0) continue;
        float alpha = 0;
        const Step step = composite(bounded.splat, x0 + static_cast<float>(x),
                                    y0 + static_cast<float>(y), left, alpha);
        if (step == Step::blends) used = true;
        if (step == Step::stops) {
          left = 0;
          --live;
        }
      }
    }
    return used;
  }
};

std::uint32_t used_in_tile(const FrameContext& frame, const Visible& visible,
                           const TileLists& lists, std::size_t index) {
  const int tile_px = frame.grid.tile_px;
  const int x0 = static_cast<int>(index) % frame.grid.columns * tile_px;
  const int y0 = static_cast<int>(index) / frame.grid.columns * tile_px;
  TilePixels tile{static_cast<float>(x0),
                  static_cast<float>(y0),
                  std::min(tile_px, frame.camera.width - x0),
                  std::min(tile_px, frame.camera.height - y0),
                  0,
                  {}};
  tile.live = tile.width * tile.height;
  tile.transmittance.fill(1);
  std::uint32_t used = 0;
  for (std::uint64_t k = lists.begin[index]; k < lists.begin[index + 1] && tile.live > 0; ++k) {
    used += tile.uses(visible.splats[lists.slots[k]]) ? 1u : 0u;
  }
  return used;
}

}  // namespace

void count_used(const FrameContext& frame, const Visible& visible, const TileLists& lists,
                Frame& result) {
  const auto tiles = static_cast<std::size_t>(frame.grid.count());
  result.used.resize(tiles);
  frame.for_chunks(tiles, 4, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t tile = begin; tile < end; ++tile)
      result.used[tile] = used_in_tile(frame, visible, lists, tile);
  });
}

}  // namespace qs::cpu
