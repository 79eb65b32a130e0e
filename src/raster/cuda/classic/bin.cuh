// SPDX-License-Identifier: MIT
//
// Stage 2 of the classic pipeline: lists one (tile, Gaussian) pair for every tile that the culling
// mode assigns to a visible Gaussian.
#pragma once

#include "raster/cuda/classic/preprocess.cuh"
#include "raster/cuda/common/scan_and_sort.cuh"

namespace qs::cuda::classic {

inline constexpr int kDepthBits = 32;  ///< bits of a key's depth

/// Keys are tile << kDepthBits | bits of the depth; values are indices in the cloud, ascending
/// before sort().
struct ClassicPairs {
  SortBuffers buffers;
  DeviceBuffer<std::uint64_t> offsets;  ///< per Gaussian: its first pair; last: number of pairs
  PinnedValue<std::uint64_t> total;     ///< number of pairs, copied to the host
  std::uint32_t count = 0;
};

/// Waits for the GPU to count the pairs: the only synchronisation within a frame. Throws
/// Error(device) if there are too many pairs to index or to fit into memory.
void bin(const FrameContext& frame, ClassicVisible& visible, ClassicPairs& pairs);

}  // namespace qs::cuda::classic
