// SPDX-License-Identifier: MIT
#include "raster/cpu/classic/depth.h"

#include <vector>

#include "raster/cpu/classic/tile_pixels.h"
#include "raster/kernel/depth.h"

namespace qs::cpu {
namespace {

void draw_tile(const FrameContext& frame, const Visible& visible, const TileLists& lists,
               std::size_t index, std::vector<PixelDepth<float>>& pixels, DepthMaps& maps) {
  TilePixels tile(frame, index);
  const auto place = [&](int x, int y) { return static_cast<std::size_t>(y * tile.width + x); };
  pixels.assign(place(0, tile.height), {});
  for (std::uint64_t k = lists.begin[index]; k < lists.begin[index + 1] && tile.live > 0; ++k) {
    const std::uint32_t slot = lists.slots[k];
    tile.composite(visible.splats[slot], [&](int x, int y, float alpha, float next) {
      pixels[place(x, y)].add(alpha, visible.depths[slot], next);
    });
  }
  for (int y = 0; y < tile.height; ++y) {
    for (int x = 0; x < tile.width; ++x) {
      const PixelDepth<float>& pixel = pixels[place(x, y)];
      const std::size_t at = frame.pixel(tile.x0 + x, tile.y0 + y);
      maps.alpha[at] = pixel.alpha();
      maps.expected[at] = pixel.expected();
      maps.median[at] = pixel.median;
    }
  }
}

}  // namespace

void draw_depth(const FrameContext& frame, const Visible& visible, const TileLists& lists,
                Frame& result) {
  const auto tiles = static_cast<std::size_t>(frame.grid.count());
  frame.for_chunks(tiles, 4, [&](std::size_t begin, std::size_t end, int) {
    std::vector<PixelDepth<float>> pixels;
    for (std::size_t tile = begin; tile < end; ++tile)
      draw_tile(frame, visible, lists, tile, pixels, result.depth);
  });
}

}  // namespace qs::cpu
