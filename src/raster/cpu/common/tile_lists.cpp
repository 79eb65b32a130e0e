// SPDX-License-Identifier: MIT
#include "raster/cpu/common/tile_lists.h"

#include <algorithm>
#include <bit>

#include <unistd.h>

#include "base/fail.h"

namespace qs::cpu {
namespace {

void collect_trace(const VisibleSlots& visible, const TileLists& lists, const SplatOf& splat_of,
                   Trace& trace) {
  std::vector<std::uint32_t> slots;
  visible.for_each([&](std::uint32_t slot) { slots.push_back(slot); });
  std::sort(slots.begin(), slots.end(), [&](std::uint32_t a, std::uint32_t b) {
    return visible.gaussians[a] < visible.gaussians[b];
  });
  for (const std::uint32_t slot : slots) {
    trace.gaussians.push_back(visible.gaussians[slot]);
    trace.footprints.push_back(visible.footprints[slot]);
    trace.depths.push_back(visible.depths[slot]);
    trace.splats.push_back(splat_of(slot));
  }
  trace.tile_begin = lists.begin;
  trace.listed.resize(lists.slots.size());
  for (std::size_t i = 0; i < trace.listed.size(); ++i)
    trace.listed[i] = visible.gaussians[lists.slots[i]];
}

}  // namespace

// Positive floats order like the unsigned integers of their bits. Slots enter by ascending index in
// the cloud, and the sort is stable, so equal depths keep that order.
void sort(const FrameContext& frame, const VisibleSlots& visible, DepthOrder& order) {
  order.resize(visible.count);
  KeyRange range;
  std::size_t at = 0;
  visible.for_each([&](std::uint32_t slot) {
    order.keys[at] = std::bit_cast<std::uint32_t>(visible.depths[slot]);
    order.values[at] = slot;
    range.include(order.keys[at++]);
  });
  radix_sort(order, range, frame.pool, frame.stop);
}

void refuse_if_too_many(std::uint64_t pairs) {
  const std::uint64_t needed = pairs * sizeof(std::uint32_t);
  const std::uint64_t memory = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                               static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  if (needed > memory / 2)
    fail(ErrorKind::device,
         "bin: this view lists {} tile pairs, which need {} MiB; the machine has {} MiB", pairs,
         needed >> 20, memory >> 20);
}

void collect(const VisibleSlots& visible, const TileLists& lists, const SplatOf& splat_of,
             const Outputs& outputs, Frame& result) {
  RenderStats& stats = result.stats;
  stats.visible = visible.count;
  stats.tile_pairs = stats.listed = lists.pairs();
  constexpr std::uint64_t kSortedEach = 2 * sizeof(std::uint32_t);  // depth and index
  stats.sort_bytes = stats.visible * kSortedEach;
  const auto tiles = static_cast<std::size_t>(result.grid.count());
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    stats.max_pairs_in_a_tile = std::max(stats.max_pairs_in_a_tile, lists.pairs(tile));
    if (outputs.pairs) result.pairs.push_back(lists.pairs(tile));
  }
  if (outputs.trace) collect_trace(visible, lists, splat_of, result.trace);
}

}  // namespace qs::cpu
