// SPDX-License-Identifier: MIT
#include <algorithm>
#include <bit>
#include <cmath>

#include "raster/cuda/fast/sort.cuh"

namespace qs::cuda::fast {
namespace {

using DepthKey = std::uint32_t;
static_assert(kInvisibleKey == kDroppedKey);

template <class Key>
void sort_by_tile_as(const FrameContext& frame, const FrameSize& size, TilePairs& pairs,
                     Scratch& scratch) {
  const DeviceCount count{&scratch.counters->listed, size.pair_capacity};
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
    sort.words = scratch.tile_words + pass * Scratch::look_back_words<Key>(size.pair_capacity);
    sort_pass(sort, frame.stream);
    pairs.keys.swap(pairs.other_keys);
    pairs.gaussians.swap(pairs.other_gaussians);
  }
}

}  // namespace

int depth_passes(const FrameContext& frame) {
  const auto& view = frame.camera.view_from_world;
  double farthest = view[3].z, rounding = std::abs(view[3].z);
  for (int axis = 0; axis < 3; ++axis) {
    const double a = view[axis].z * static_cast<double>(frame.cloud.low[axis]);
    const double b = view[axis].z * static_cast<double>(frame.cloud.high[axis]);
    farthest += std::max(a, b);
    rounding += std::abs(a) + std::abs(b);
  }
  const auto depth = static_cast<float>(farthest + 1e-5 * rounding);
  const std::uint32_t nearest = nearest_bits(frame.camera);
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(depth > 0.0f ? depth : INFINITY);
  const int key_bits = std::bit_width(bits > nearest ? bits - nearest : 0);
  return std::clamp((key_bits + Radix<DepthKey>::kBits - 1) / Radix<DepthKey>::kBits, 1,
                    Radix<DepthKey>::kPasses);
}

void DepthOrder::reserve(const FrameSize& size) {
  if (size.uses_macro_tiles()) return;
  for (auto* buffer : {&gaussians, &other_gaussians, &keys, &other_keys}) {
    buffer->reserve("the frame's Gaussians", size.gaussians);
  }
}

void TilePairs::reserve(const FrameSize& size) {
  if (size.uses_macro_tiles()) {
    gaussians.reserve("the frame's tile pairs", size.pair_capacity);
    return;
  }
  const std::size_t key_bytes =
      size.uses_16_bit_keys() ? sizeof(std::uint16_t) : sizeof(std::uint32_t);
  const std::uint64_t held =
      keys.bytes() + other_keys.bytes() + gaussians.bytes() + other_gaussians.bytes();
  require_memory("the frame's tile pairs",
                 2 * (key_bytes + sizeof(std::uint32_t)) * size.pair_capacity, held);
  for (auto* buffer : {&keys, &other_keys}) {
    buffer->reserve("the frame's tile pairs", key_bytes * size.pair_capacity);
  }
  for (auto* buffer : {&gaussians, &other_gaussians}) {
    buffer->reserve("the frame's tile pairs", size.pair_capacity);
  }
}

void sort_by_depth(const FrameContext& frame, const FrameSize& size, const Visible& visible,
                   Scratch& scratch, DepthOrder& order) {
  count_digits(visible.depth_keys.data(), size.gaussians, scratch.depth_digits,
               &scratch.counters->visible, frame.stream);
  for (int pass = 0, passes = depth_passes(frame); pass < passes; ++pass) {
    const bool first = pass == 0, last = pass + 1 == passes;
    SortPass<DepthKey> sort{};
    sort.count = {first ? nullptr : &scratch.counters->visible, size.gaussians};
    sort.pass = pass;
    sort.drops = first;
    sort.keys = first ? visible.depth_keys.data() : order.keys.data();
    sort.values = first ? nullptr : order.gaussians.data();
    sort.sorted_keys = last ? nullptr : order.other_keys.data();
    sort.sorted_values = order.other_gaussians.data();
    sort.digit_counts = scratch.depth_digits + pass * kBins<DepthKey>;
    sort.words = scratch.depth_words + pass * Scratch::look_back_words<DepthKey>(size.gaussians);
    sort_pass(sort, frame.stream);
    order.keys.swap(order.other_keys);
    order.gaussians.swap(order.other_gaussians);
  }
}

void sort_by_tile(const FrameContext& frame, const FrameSize& size, TilePairs& pairs,
                  Scratch& scratch) {
  if (size.uses_16_bit_keys()) {
    sort_by_tile_as<std::uint16_t>(frame, size, pairs, scratch);
  } else {
    sort_by_tile_as<std::uint32_t>(frame, size, pairs, scratch);
  }
}

}  // namespace qs::cuda::fast
