// SPDX-License-Identifier: MIT
#include "raster/cuda/train/order.cuh"
#include "raster/cuda/train/parameters.cuh"

namespace qs::cuda::train {
namespace {

/// One thread per rank, and one more.
__global__ void __launch_bounds__(kThreads)
    gather_counts(std::uint32_t count, const std::uint32_t* gaussians,
                  const std::uint32_t* tile_counts, std::uint32_t* counts) {
  const std::uint32_t rank = blockIdx.x * blockDim.x + threadIdx.x;
  if (rank > count) return;
  counts[rank] = rank < count ? tile_counts[gaussians[rank]] : 0;
}

}  // namespace

void DepthOrder::reserve(std::uint32_t count) {
  constexpr const char* kWhat = "the step's Gaussians";
  const auto room = static_cast<std::uint32_t>(with_room(count));
  buffers.reserve(kWhat, room);
  counts.reserve(kWhat, std::size_t{room} + 1);
  offsets.reserve(kWhat, std::size_t{room} + 1);
}

void sort_by_depth(std::uint32_t count, const std::uint32_t* tile_counts, cudaStream_t stream,
                   DepthOrder& order) {
  if (count == 0) return;
  sort_pairs(order.buffers, count, 32, stream);
  launch("sort_by_depth", gather_counts, blocks_for(std::uint64_t{count} + 1), stream, count,
         order.gaussians(), tile_counts, order.counts.data());
  exclusive_sum(order.counts.data(), order.offsets.data(), count + 1, order.buffers.scratch,
                stream);
}

}  // namespace qs::cuda::train
