// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/sort.cuh"

namespace qs::cuda::fast {
namespace {

using DepthKey = std::uint32_t;
static_assert(kInvisibleKey == kDroppedKey);

template <class Key>
void sort_by_tile_as(const FrameContext& frame, const FrameSize& size, TilePairs& pairs,
                     Scratch& scratch) {
  const DeviceCount count{&scratch.counters->listed, size.pairs};
  for (int pass = 0; pass < Radix<Key>::kPasses; ++pass) {
    const bool last = pass + 1 == Radix<Key>::kPasses;
    SortPass<Key> sort{};
    sort.count = count;
    sort.pass = pass;
    sort.keys = pairs.keys_as<Key>();
    sort.values = pairs.gaussians.data();
    sort.sorted_keys = last ? nullptr : pairs.other_keys_as<Key>();
    sort.sorted_values = pairs.other_gaussians.data();
    sort.ranges = last ? scratch.ranges : nullptr;
    sort.digit_counts = scratch.tile_digits + pass * kBins<Key>;
    sort.words = scratch.tile_words + pass * Scratch::look_back_words<Key>(size.pairs);
    sort_pass(sort, frame.stream);
    pairs.keys.swap(pairs.other_keys);
    pairs.gaussians.swap(pairs.other_gaussians);
  }
}

}  // namespace

void DepthOrder::reserve(std::size_t size) {
  for (auto* buffer : {&gaussians, &other_gaussians, &keys, &other_keys}) {
    buffer->reserve("the frame's Gaussians", size);
  }
}

void TilePairs::reserve(const FrameSize& size) {
  const std::size_t key_bytes = size.narrow() ? sizeof(std::uint16_t) : sizeof(std::uint32_t);
  const std::uint64_t held =
      keys.bytes() + other_keys.bytes() + gaussians.bytes() + other_gaussians.bytes();
  require_memory("the frame's tile pairs", 2 * (key_bytes + sizeof(std::uint32_t)) * size.pairs,
                 held);
  for (auto* buffer : {&keys, &other_keys}) {
    buffer->reserve("the frame's tile pairs", key_bytes * size.pairs);
  }
  for (auto* buffer : {&gaussians, &other_gaussians}) {
    buffer->reserve("the frame's tile pairs", size.pairs);
  }
}

void sort_by_depth(const FrameContext& frame, const FrameSize& size, const Visible& visible,
                   Scratch& scratch, DepthOrder& order) {
  count_digits(visible.depth_keys.data(), size.gaussians, scratch.depth_digits,
               &scratch.counters->visible, frame.stream);
  const std::uint32_t* keys = visible.depth_keys.data();
  const std::uint32_t* values = nullptr;
  for (int pass = 0; pass < Radix<DepthKey>::kPasses; ++pass) {
    const bool first = pass == 0, last = pass + 1 == Radix<DepthKey>::kPasses;
    const bool to_other = pass % 2 != 0;
    SortPass<DepthKey> sort{};
    sort.count = {first ? nullptr : &scratch.counters->visible, size.gaussians};
    sort.pass = pass;
    sort.drops = first;
    sort.may_rest = last;
    sort.keys = keys;
    sort.values = values;
    sort.sorted_keys = last ? nullptr : (to_other ? order.other_keys : order.keys).data();
    sort.sorted_values = (to_other ? order.other_gaussians : order.gaussians).data();
    sort.digit_counts = scratch.depth_digits + pass * kBins<DepthKey>;
    sort.words = scratch.depth_words + pass * Scratch::look_back_words<DepthKey>(size.gaussians);
    sort_pass(sort, frame.stream);
    keys = sort.sorted_keys;
    values = sort.sorted_values;
  }
}

void sort_by_tile(const FrameContext& frame, const FrameSize& size, TilePairs& pairs,
                  Scratch& scratch) {
  if (size.narrow()) {
    sort_by_tile_as<std::uint16_t>(frame, size, pairs, scratch);
  } else {
    sort_by_tile_as<std::uint32_t>(frame, size, pairs, scratch);
  }
}

}  // namespace qs::cuda::fast
