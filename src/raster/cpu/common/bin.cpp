// SPDX-License-Identifier: MIT
// Compiled alone: clang optimises the sanitized walks of all modes for minutes in a larger unit.
#include <algorithm>
#include <utility>

#include "raster/cpu/common/tile_lists.h"
#include "raster/kernel/cull/modes.h"

namespace qs::cpu {
namespace {

/// A segment of fewer Gaussians is not worth a thread.
constexpr std::size_t kSmallestSegment = 256;

// Cuts the depth order into one segment per thread, or fewer. The first loop counts the pairs of
// each (tile, segment), which gives each its own range of the list, ordered by tile and then by
// segment. The second loop fills these ranges. The result does not depend on the number of
// segments.
template <class P, int kTilePx>
void bin_with(const FrameContext& frame, const VisibleSlots& visible, const DepthOrder& order,
              TileLists& lists) {
  const auto tiles = static_cast<std::size_t>(frame.grid.count());
  const auto segments = std::clamp<std::size_t>(order.slots().size() / kSmallestSegment, 1,
                                                static_cast<std::size_t>(frame.pool.size()));
  const std::size_t segment_size = (order.slots().size() + segments - 1) / segments;
  std::vector<std::uint64_t>& cursors = lists.cursors;  // [segment][tile]
  cursors.assign(segments * tiles, 0);

  const auto for_each_pair = [&](std::size_t segment, const auto& visit) {
    const std::size_t begin = std::min(segment * segment_size, order.slots().size());
    const std::size_t end = std::min(begin + segment_size, order.slots().size());
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t slot = order.slots()[i];
      for_each_tile<P, kTilePx>(visible.footprints[slot], frame.grid, [&](int tile) {
        visit(cursors[segment * tiles + static_cast<std::size_t>(tile)], slot);
      });
    }
  };

  // Count the pairs.
  frame.for_chunks(segments, 1, [&](std::size_t segment, std::size_t, int) {
    for_each_pair(segment, [](std::uint64_t& count, std::uint32_t) { ++count; });
  });

  // Turn the counts into ranges of the list.
  lists.begin.resize(tiles + 1);
  std::uint64_t sum = 0;
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    lists.begin[tile] = sum;
    for (std::size_t segment = 0; segment < segments; ++segment)
      sum += std::exchange(cursors[segment * tiles + tile], sum);
  }
  lists.begin[tiles] = sum;
  refuse_if_too_many(sum);
  lists.slots.resize(sum);

  // Fill the ranges.
  frame.for_chunks(segments, 1, [&](std::size_t segment, std::size_t, int) {
    for_each_pair(segment,
                  [&](std::uint64_t& cursor, std::uint32_t slot) { lists.slots[cursor++] = slot; });
  });
}

}  // namespace

void bin(const FrameContext& frame, const VisibleSlots& visible, const DepthOrder& order,
         TileLists& lists) {
  with_culler(frame.settings.mode, [&]<class P>(P) {
    with_tile_px(frame.grid.tile_px,
                 [&](auto px) { bin_with<P, px()>(frame, visible, order, lists); });
  });
}

}  // namespace qs::cpu
