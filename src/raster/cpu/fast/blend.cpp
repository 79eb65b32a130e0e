// SPDX-License-Identifier: MIT
#include <algorithm>
#include <bit>

#include "raster/cpu/fast/tile.h"

namespace qs::cpu::fast {
namespace {

/// Orders tiles by descending class of list length (bit width), and within a class by position.
/// Long lists start early, and neighbours, which share Gaussians, follow each other.
void queue_longest_first(const TileLists& lists, std::size_t tiles, TileQueue& queue) {
  constexpr int kClasses = 33;
  std::size_t begins[kClasses + 1] = {};
  const auto class_of = [&](std::size_t tile) {
    return static_cast<std::size_t>(kClasses - 1 - std::bit_width(lists.pairs(tile)));
  };
  for (std::size_t tile = 0; tile < tiles; ++tile) ++begins[class_of(tile) + 1];
  for (int c = 0; c < kClasses; ++c) begins[c + 1] += begins[c];
  queue.tiles.resize(tiles);
  for (std::size_t tile = 0; tile < tiles; ++tile)
    queue.tiles[begins[class_of(tile)]++] = static_cast<std::uint32_t>(tile);
}

}  // namespace

void blend(const FrameContext& frame, const FastVisible& visible, const TileLists& lists,
           TileQueue& queue, const Outputs& outputs, Frame& result) {
  const auto tiles = static_cast<std::size_t>(frame.grid.count());
  queue_longest_first(lists, tiles, queue);
  frame.for_frame(tiles, 2, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t tile = queue.tiles[i];
      const int x0 = static_cast<int>(tile) % frame.grid.columns * kTileSize;
      const int y0 = static_cast<int>(tile) / frame.grid.columns * kTileSize;
      const std::size_t pixel = frame.pixel(x0, y0);
      blend_tile({.list = lists.slots.data() + lists.begin[tile],
                  .length = lists.pairs(tile),
                  .records = visible.records.data(),
                  .x0 = x0,
                  .y0 = y0,
                  .width = std::min(kTileSize, frame.camera.width - x0),
                  .height = std::min(kTileSize, frame.camera.height - y0),
                  .background = frame.settings.background,
                  .least_transmittance = static_cast<float>(frame.least_transmittance()),
                  .color = outputs.color ? result.color.values.data() + 3 * pixel : nullptr,
                  .evaluated = outputs.evaluated ? result.evaluated.data() + pixel : nullptr,
                  .stride = static_cast<std::size_t>(frame.camera.width)});
    }
  });
}

}  // namespace qs::cpu::fast
