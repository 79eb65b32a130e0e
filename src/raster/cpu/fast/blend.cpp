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

// The job of a tile that draws nothing yet. `x0`, `y0`: the tile's first pixel.
TileJob job_of(const FrameContext& frame, const FastVisible& visible, const TileLists& lists,
               std::size_t tile, int x0, int y0) {
  return {.list = lists.slots.data() + lists.begin[tile],
          .length = lists.pairs(tile),
          .records = visible.records.data(),
          .x0 = x0,
          .y0 = y0,
          .width = std::min(kTileSize, frame.camera.width - x0),
          .height = std::min(kTileSize, frame.camera.height - y0),
          .background = glm::vec3(0),
          .least_transmittance = static_cast<float>(frame.least_transmittance()),
          .color = nullptr,
          .evaluated = nullptr,
          .stride = 0};
}

}  // namespace

void blend(const FrameContext& frame, const FastVisible& visible, const TileLists& lists,
           TileQueue& queue, const Outputs& outputs, Frame& result, bool depths) {
  const auto tiles = static_cast<std::size_t>(frame.grid.count());
  queue_longest_first(lists, tiles, queue);
  frame.for_frame(tiles, 2, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t tile = queue.tiles[i];
      const int x0 = static_cast<int>(tile) % frame.grid.columns * kTileSize;
      const int y0 = static_cast<int>(tile) / frame.grid.columns * kTileSize;
      const std::size_t pixel = frame.pixel(x0, y0);
      TileJob job = job_of(frame, visible, lists, tile, x0, y0);
      job.background = frame.settings.background;
      if (outputs.color) job.color = result.color.values.data() + 3 * pixel;
      if (outputs.evaluated) job.evaluated = result.evaluated.data() + pixel;
      job.stride = static_cast<std::size_t>(frame.camera.width);
      job.depths = depths;
      blend_tile(job);
    }
  });
}

void mark_seen(const FrameContext& frame, const FastVisible& visible, const TileLists& lists,
               const SeenPixels& pixels, GaussianSet& seen) {
  const PixelBox& box = pixels.box;
  if (box.x0 >= box.x1 || box.y0 >= box.y1) return;
  const int left = box.x0 / kTileSize, top = box.y0 / kTileSize;
  const int columns = (box.x1 - 1) / kTileSize - left + 1;
  const int rows = (box.y1 - 1) / kTileSize - top + 1;
  const auto mark = [&](std::size_t tile, int x0, int y0) {
    std::uint8_t chosen[kTileSize * kTileSize] = {};
    const int x = std::max(x0, box.x0), width = std::min(x0 + kTileSize, box.x1) - x;
    for (int y = std::max(y0, box.y0); y < std::min(y0 + kTileSize, box.y1); ++y)
      std::copy_n(pixels.chosen.data() + (y - box.y0) * (box.x1 - box.x0) + x - box.x0, width,
                  chosen + (y - y0) * kTileSize + x - x0);
    if (std::ranges::count(chosen, 0) == kTileSize * kTileSize) return;
    std::vector<std::uint8_t> marks(lists.pairs(tile));
    TileJob job = job_of(frame, visible, lists, tile, x0, y0);
    job.seen = marks.data();
    job.chosen = chosen;
    job.weight = pixels.weight;
    blend_tile(job);
    for (std::size_t k = 0; k < marks.size(); ++k)
      if (marks[k] != 0) seen.add_atomically(visible.gaussians[job.list[k]]);
  };
  frame.for_chunks(static_cast<std::size_t>(columns * rows), 4,
                   [&](std::size_t begin, std::size_t end, int) {
                     for (std::size_t i = begin; i < end; ++i) {
                       const int column = left + static_cast<int>(i) % columns;
                       const int row = top + static_cast<int>(i) / columns;
                       mark(static_cast<std::size_t>(row * frame.grid.columns + column),
                            column * kTileSize, row * kTileSize);
                     }
                   });
}

}  // namespace qs::cpu::fast
