// SPDX-License-Identifier: MIT
//
// Stages 2 and 3 of the fast pipeline: the lists of tiles. Every macro-tile is sorted by depth in
// the shared memory of a block, which then writes the lists of its tiles. Full macro-tiles are cut
// into slices first (slices.cu).
#pragma once

#include "raster/cuda/fast/preprocess.cuh"

namespace qs::cuda::fast {

struct TilePairs {
  DeviceBuffer<std::uint32_t> gaussians;  ///< the lists of all tiles, front to back

  void reserve(const FrameSize& size) {
    gaussians.reserve("the frame's tile pairs", size.pair_capacity);
  }
};

/// The largest FullSize::slice_capacity and sample_capacity on the current device.
std::uint32_t most_in_shared_memory();

/// Sorts the Gaussians of macro-tiles by depth, then by index, and writes the lists of their tiles,
/// the lists' ranges and schedule. Also counts the pairs. Pairs beyond size.pair_capacity are counted
/// but not written. Macro-tiles that are full list nothing.
void list_usual(const FrameContext& frame, const FrameSize& size, Scratch& scratch,
                TilePairs& pairs);

/// The same for the full macro-tiles, in four kernels. Slices and spilled entries beyond the
/// capacities of size.full are counted but not listed.
void list_full(const FrameContext& frame, const FrameSize& size, Scratch& scratch, TilePairs& pairs,
               cudaStream_t stream);

}  // namespace qs::cuda::fast
