// SPDX-License-Identifier: MIT
#include "learn/diff/cuda/list.cuh"
#include "learn/step/cuda/list.cuh"
#include "raster/cuda/common/limits.cuh"

namespace qs::cuda::train {
namespace {

/// Lists nothing if there are more pairs than frame.pairs has room for.
void enqueue_lists(const StepView& view, std::uint32_t count, ForwardFrame& frame) {
  ListedPairs& pairs = frame.pairs;
  diff::list_pairs(
      view.settings.mode,
      {count,
       frame.tile_counts.data(),
       frame.first_places.data(),
       frame.footprints.arrays(),
       view.grid(),
       {frame.total.sum.data(), pairs.room(), frame.depth_keys.data(), pairs.owners.data(),
        pairs.tiles.data(), pairs.slots.data(), pairs.entries.data(), pairs.places.data(),
        frame.lists.sizes.data(), frame.lists.ranges.data(), frame.lists.class_sizes.data(),
        frame.lists.scheduled.data(), static_cast<unsigned>(view.grid().count())}},
      view.stream);
}

}  // namespace

void ListedPairs::reserve(std::uint32_t pairs) {
  if (pairs <= room()) return;  // places is reserved last
  constexpr const char* kWhat = "the step's pairs";
  constexpr auto bytes_for = [](std::uint64_t count) {
    return count * (4 * sizeof(std::uint32_t) + sizeof(SortEntry));
  };
  const std::uint64_t held = bytes_for(room());
  require_memory(kWhat, bytes_for(pairs), held);
  const std::uint32_t more = with_headroom(pairs, UINT32_MAX, held, bytes_for);
  places.release();
  for (auto* buffer : {&owners, &tiles, &slots}) buffer->reserve(kWhat, more);
  entries.reserve(kWhat, more);
  places.reserve(kWhat, more);
}

void TileLists::reserve(unsigned tiles) {
  constexpr const char* kWhat = "the step's tiles";
  sizes.reserve(kWhat, tiles);
  ranges.reserve(kWhat, tiles);
  class_sizes.reserve(kWhat, kLengthClasses);
  scheduled.reserve(kWhat, std::size_t{kLengthClasses} * tiles);
}

void list_view(const StepView& view, std::uint32_t count, ForwardFrame& frame) {
  frame.pairs.count = 0;
  frame.lists.reserve(static_cast<unsigned>(view.grid().count()));
  enqueue_lists(view, count, frame);
  frame.total.arrived.wait();
  view.throw_if_cancelled();
  require_indexable(*frame.total.copy);
  const auto pairs = static_cast<std::uint32_t>(*frame.total.copy);
  if (pairs > frame.pairs.room()) {
    frame.pairs.reserve(pairs);
    enqueue_lists(view, count, frame);
  }
  frame.pairs.count = pairs;
}

}  // namespace qs::cuda::train
