// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/sort.cuh"

namespace qs::cuda::fast {
namespace {

using DepthKey = std::uint32_t;
static_assert(kDepthBits == Radix<DepthKey>::kBits * Radix<DepthKey>::kPasses);
static_assert(kInvisibleKey == kDroppedKey);

constexpr unsigned kRangeBlocks = 1024;

/// The first and the last pair of a tile say so.
template <class Key>
__global__ void __launch_bounds__(kThreads)
    find_ranges(const Key* keys, DeviceCount count, uint2* ranges) {
  const std::uint32_t size = count.get();
  for (std::uint32_t i = blockIdx.x * kThreads + threadIdx.x; i < size; i += gridDim.x * kThreads) {
    const Key tile = keys[i];
    if (i == 0 || keys[i - 1] != tile) ranges[tile].x = i;
    if (i + 1 == size || keys[i + 1] != tile) ranges[tile].y = i + 1;
  }
}

template <class Key>
void sort_by_tile_as(const FrameContext& frame, const FrameSize& size, TilePairs& pairs,
                     Scratch& scratch) {
  const DeviceCount count{&scratch.counters->listed, size.pairs};
  for (int pass = 0; pass < Radix<Key>::kPasses; ++pass) {
    sort_pass<Key>({count, pass, false, pairs.keys_as<Key>(), pairs.gaussians.data(),
                    pairs.other_keys_as<Key>(), pairs.other_gaussians.data(),
                    scratch.tile_digits + pass * kBins<Key>,
                    scratch.tile_words + pass * Scratch::look_back_words<Key>(size.pairs)},
                   frame.stream);
    pairs.keys.swap(pairs.other_keys);
    pairs.gaussians.swap(pairs.other_gaussians);
  }
  const unsigned blocks = std::min(kRangeBlocks, blocks_for(size.pairs));
  launch("sort", find_ranges<Key>, blocks, frame.stream, pairs.keys_as<Key>(), count,
         scratch.ranges);
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
  constexpr auto kBinsOfPass = kBins<DepthKey>;
  count_digits(visible.depth_keys.data(), size.gaussians, scratch.depth_digits,
               &scratch.counters->visible, frame.stream);
  const std::size_t words = Scratch::look_back_words<DepthKey>(size.gaussians);
  const DeviceCount all{nullptr, size.gaussians};
  const DeviceCount kept{&scratch.counters->visible, size.gaussians};
  sort_pass<DepthKey>({all, 0, true, visible.depth_keys.data(), nullptr, order.keys.data(),
                       order.gaussians.data(), scratch.depth_digits, scratch.depth_words},
                      frame.stream);
  sort_pass<DepthKey>({kept, 1, false, order.keys.data(), order.gaussians.data(),
                       order.other_keys.data(), order.other_gaussians.data(),
                       scratch.depth_digits + kBinsOfPass, scratch.depth_words + words},
                      frame.stream);
  sort_pass<DepthKey>({kept, 2, false, order.other_keys.data(), order.other_gaussians.data(),
                       nullptr, order.gaussians.data(), scratch.depth_digits + 2 * kBinsOfPass,
                       scratch.depth_words + 2 * words},
                      frame.stream);
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
