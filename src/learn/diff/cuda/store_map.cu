// SPDX-License-Identifier: MIT
#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/diff/cuda/store_map.h"
#include "raster/cuda/common/check.cuh"

namespace qs::cuda::diff {
namespace {

__device__ void store(float value, float& to) { to = value; }
/// As to_8bit() of image.h.
__device__ void store(float value, std::uint8_t& to) {
  to = static_cast<std::uint8_t>(255.0f * fminf(fmaxf(0.0f, value), 1.0f) + 0.5f);
}

/// A thread for each value.
template <class T>
__global__ void store_values(PackedMap map, Pixels<T> to) {
  const std::size_t i = std::size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  const auto channels = static_cast<std::size_t>(map.channels);
  const auto width = static_cast<std::size_t>(map.width);
  const std::size_t pixel = i / channels;
  if (pixel >= width * static_cast<std::size_t>(map.height)) return;
  store(map.values[i], to.at(static_cast<int>(pixel % width), static_cast<int>(pixel / width),
                             static_cast<int>(i % channels)));
}

template <class T>
void enqueue(const PackedMap& map, const Pixels<T>& to, const Queue& queue) {
  const std::size_t count = static_cast<std::size_t>(map.height) *
                            static_cast<std::size_t>(map.width) *
                            static_cast<std::size_t>(map.channels);
  launch("pictures", store_values<T>, blocks_for(count), stream_of(queue), map, to);
}

}  // namespace

void store_map(const PackedMap& map, const Pixels<float>& to, const Queue& queue) {
  enqueue(map, to, queue);
}

void store_map(const PackedMap& map, const Pixels<std::uint8_t>& to, const Queue& queue) {
  enqueue(map, to, queue);
}

}  // namespace qs::cuda::diff
