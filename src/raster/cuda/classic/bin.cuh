// SPDX-License-Identifier: MIT
//
// Stage 2: one (tile, Gaussian) pair for every tile that the mode gives a visible Gaussian.
#pragma once

#include "raster/cuda/classic/preprocess.cuh"
#include "raster/cuda/classic/scan_and_sort.cuh"

namespace qs::cuda {

/// Keys are tile << 32 | bits of the depth, values are indices in the cloud, ascending.
struct TilePairs {
  SortBuffers buffers;
  DeviceBuffer<std::uint64_t> offsets;  ///< per Gaussian, its first pair; then their number
  PinnedValue<std::uint64_t> total;     ///< the frame's pairs, as the host reads them
  std::uint32_t count = 0;
};

/// Pairs are counted with 64 bits and indexed with 31.
inline constexpr std::uint64_t kMaxPairs = 0x7fffffff;

/// Waits for the number of pairs, the only time that a frame waits for the GPU. Throws
/// Error(device) when they are too many or do not fit into memory.
void bin(const FrameContext& frame, Visible& visible, TilePairs& pairs);

}  // namespace qs::cuda
