// SPDX-License-Identifier: MIT
//
// Sums in orders that do not depend on the order in which threads run: of the numbers of the pairs
// of each Gaussian, in the order of tiles, which is the order of their places; and of rows of
// numbers, in double precision.
#pragma once

#include "learn/diff/cuda/frame_blocks.cuh"
#include "raster/cuda/common/warp.cuh"

namespace qs::cuda::diff {

/// The sum of values[k * kNumbers] for k in [begin, end), in this order. The loads of a group do
/// not wait for each other.
template <unsigned kNumbers, unsigned kGroup>
__device__ void add_groups(const float* values, std::uint32_t& begin, std::uint32_t end,
                           float& sum) {
  for (; begin + kGroup <= end; begin += kGroup) {
    float group[kGroup];
#pragma unroll
    for (unsigned k = 0; k < kGroup; ++k) group[k] = values[std::size_t{begin + k} * kNumbers];
#pragma unroll
    for (unsigned k = 0; k < kGroup; ++k) sum += group[k];
  }
}

/// Pairs of Gaussians of which a thread adds up one number alone.
constexpr std::uint32_t kFewPairs = 64;

struct SumInput {
  std::uint32_t count;  ///< Gaussians
  const std::uint32_t *first_places, *tile_counts;
  const float* pairs;
  float* sums;
};

/// Adds up the pairs of a Gaussian in their order. A warp reads the next pairs while some of its
/// lanes add. All lanes call it; `chunk` is memory of the warp.
template <unsigned kNumbers>
__device__ void sum_many_pairs(const SumInput& in, std::uint32_t gaussian, float* chunk) {
  const unsigned lane = lane_index();
  const std::uint32_t size = in.tile_counts[gaussian];
  const float* const values = in.pairs + std::size_t{in.first_places[gaussian]} * kNumbers;
  float next[kNumbers];
  const auto read = [&](std::uint32_t first) {
#pragma unroll
    for (unsigned k = 0; k < kNumbers; ++k) {
      const std::uint64_t at = std::uint64_t{first} * kNumbers + k * kWarp + lane;
      next[k] = at < std::uint64_t{size} * kNumbers ? values[at] : 0.0f;
    }
  };
  float sum = 0;
  read(0);
  for (std::uint32_t first = 0; first < size; first += kWarp) {
#pragma unroll
    for (unsigned k = 0; k < kNumbers; ++k) chunk[k * kWarp + lane] = next[k];
    __syncwarp();
    read(first + kWarp);
    if (lane < kNumbers) {
      const std::uint32_t end = min(size - first, kWarp);
      for (std::uint32_t k = 0; k < end; ++k) sum += chunk[k * kNumbers + lane];
    }
    __syncwarp();
  }
  if (lane < kNumbers) in.sums[std::size_t{gaussian} * kNumbers + lane] = sum;
}

/// The first blocks have a thread per Gaussian, and their warps add up the Gaussians of many pairs.
/// The others have a thread per number of a Gaussian's kNumbers sums, so the threads of a Gaussian
/// read neighbouring addresses. The gradients are computed in another kernel, which need not wait
/// for the long lists of large Gaussians.
template <unsigned kNumbers>
__global__ void __launch_bounds__(kThreads) sum_gaussians(SumInput in, unsigned blocks_of_many) {
  __shared__ float chunks[kThreads / kWarp][kWarp * kNumbers];
  if (blockIdx.x < blocks_of_many) {
    const std::uint32_t gaussian = blockIdx.x * kThreads + threadIdx.x;
    const bool has_many = gaussian < in.count && in.tile_counts[gaussian] > kFewPairs;
    for (unsigned many = __ballot_sync(kAllLanes, has_many); many != 0; many &= many - 1)
      sum_many_pairs<kNumbers>(in, gaussian - lane_index() + lowest_bit(many),
                               chunks[threadIdx.x / kWarp]);
    return;
  }
  const std::uint64_t thread = std::uint64_t{blockIdx.x - blocks_of_many} * kThreads + threadIdx.x;
  const auto gaussian = static_cast<std::uint32_t>(thread / kNumbers);
  if (gaussian >= in.count) return;
  const std::uint32_t size = in.tile_counts[gaussian];
  if (size > kFewPairs) return;
  const float* const values = in.pairs + thread % kNumbers;
  std::uint32_t begin = size > 0 ? in.first_places[gaussian] : 0;
  const std::uint32_t end = begin + size;
  float sum = 0;
  add_groups<kNumbers, 16>(values, begin, end, sum);
  add_groups<kNumbers, 4>(values, begin, end, sum);
  add_groups<kNumbers, 1>(values, begin, end, sum);
  in.sums[thread] = sum;
}

/// Enqueues the sums of kNumbers numbers each of the first `count` Gaussians.
template <unsigned kNumbers>
void sum_pairs_of_gaussians(const GpuGaussianBlock& gaussians, std::uint32_t count,
                            const void* pairs, void* sums, cudaStream_t stream) {
  static_assert(kNumbers <= kWarp);
  if (count == 0) return;
  const unsigned blocks_of_many = blocks_for(count);
  launch("sum_gaussians", sum_gaussians<kNumbers>,
         blocks_of_many + blocks_for(std::uint64_t{kNumbers} * count), stream,
         SumInput{count, gaussians.first_places, gaussians.tile_counts,
                  static_cast<const float*>(pairs), static_cast<float*>(sums)},
         blocks_of_many);
}

/// out[k] is the sum of number k of all rows, which are packed. One block.
template <class Out>
__global__ void __launch_bounds__(kThreads)
    add_rows(const double* rows, unsigned count, unsigned numbers, Out* out) {
  for (unsigned k = 0; k < numbers; ++k) {
    double own = 0;
    for (unsigned row = threadIdx.x; row < count; row += kThreads)
      own += rows[std::size_t{row} * numbers + k];
    const double sum = sum_of_block<kThreads>(own).total;
    if (threadIdx.x == 0) out[k] = static_cast<Out>(sum);
  }
}

}  // namespace qs::cuda::diff
