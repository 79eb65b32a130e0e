// SPDX-License-Identifier: MIT
//
// The Gaussians of a training step from near to far. Pairs are listed in this order, so sorting the
// pairs by tile alone makes the tile lists.
#pragma once

#include "raster/cuda/scan_and_sort.cuh"
#include "raster/cuda/stream.cuh"

namespace qs::cuda::train {

/// The place of a Gaussian in the order is its rank.
struct DepthOrder {
  static constexpr std::uint32_t kInvisibleKey = 0xffffffffu;  ///< behind all others

  /// Keys: bits of the depths, which are positive, or kInvisibleKey; values: Gaussians. Equal keys
  /// are in the order of the Gaussians' indices.
  SortBuffers<std::uint32_t> buffers;
  DeviceBuffer<std::uint32_t> counts;  ///< by rank: pairs; the additional last element is 0
  /// by rank: the first pair; the additional last element is the number of pairs
  DeviceBuffer<std::uint64_t> offsets;

  const std::uint32_t* gaussians() const { return buffers.values.data(); }

  void reserve(std::uint32_t count);
};

/// Sorts `count` Gaussians by the keys, and finds counts and offsets. `tile_counts` are the pairs
/// by Gaussian. Does not wait.
void sort_by_depth(std::uint32_t count, const std::uint32_t* tile_counts, cudaStream_t stream,
                   DepthOrder& order);

}  // namespace qs::cuda::train
