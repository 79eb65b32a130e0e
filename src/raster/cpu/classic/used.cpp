// SPDX-License-Identifier: MIT
#include "raster/cpu/classic/used.h"

#include "raster/cpu/classic/tile_pixels.h"

namespace qs::cpu {
namespace {

std::uint32_t used_in_tile(const FrameContext& frame, const Visible& visible,
                           const TileLists& lists, std::size_t index) {
  TilePixels tile(frame, index);
  std::uint32_t used = 0;
  for (std::uint64_t k = lists.begin[index]; k < lists.begin[index + 1] && tile.live > 0; ++k) {
    bool is_used = false;
    tile.composite(visible.splats[lists.slots[k]], [&](int, int, float, float) { is_used = true; });
    used += is_used ? 1u : 0u;
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
