// SPDX-License-Identifier: MIT
#include "raster/cpu/common/tile_lists.h"

#include <algorithm>
#include <bit>

#include <unistd.h>

#include "base/fail.h"

namespace qs::cpu {
namespace {

void collect_trace(const FrameContext& frame, const VisibleSlots& visible, const TileLists& lists,
                   const SplatOf& splat_of, Trace& trace) {
  // The slots by their Gaussians, ascending.
  constexpr std::uint32_t kNone = 0xffffffff;
  std::vector<std::uint32_t> slot_of(frame.cloud.size(), kNone), slots;
  visible.for_each([&](std::uint32_t slot) { slot_of[visible.gaussians[slot]] = slot; });
  slots.reserve(visible.count);
  for (const std::uint32_t slot : slot_of)
    if (slot != kNone) slots.push_back(slot);
  trace.gaussians.resize(slots.size());
  trace.footprints.resize(slots.size());
  trace.depths.resize(slots.size());
  trace.splats.resize(slots.size());
  frame.pool.for_each(slots.size(), 1 << 14, [&](std::size_t i) {
    const std::uint32_t slot = slots[i];
    trace.gaussians[i] = visible.gaussians[slot];
    trace.footprints[i] = visible.footprints[slot];
    trace.depths[i] = visible.depths[slot];
    trace.splats[i] = splat_of(slot);
  });
  trace.tile_begin = lists.begin;
  trace.listed.resize(lists.slots.size());
  frame.pool.for_each(trace.listed.size(), 1 << 16,
                      [&](std::size_t i) { trace.listed[i] = visible.gaussians[lists.slots[i]]; });
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

void collect(const FrameContext& frame, const VisibleSlots& visible, const TileLists& lists,
             const SplatOf& splat_of, const Outputs& outputs, Frame& result) {
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
  if (outputs.trace) collect_trace(frame, visible, lists, splat_of, result.trace);
}

}  // namespace qs::cpu
