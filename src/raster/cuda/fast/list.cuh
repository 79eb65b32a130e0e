// SPDX-License-Identifier: MIT
//
// Stages 2 and 3 of the fast pipeline: the lists of tiles. Every macro-tile is sorted by depth in
// the shared memory of a block, which then writes the lists of its tiles. Full macro-tiles are cut
// into slices first (slices.cu).
#pragma once

#include "raster/cuda/fast/preprocess.cuh"

namespace qs::cuda::fast {

struct FastPairs {
  DeviceBuffer<std::uint32_t> gaussians;  ///< the lists of all tiles, front to back: places

  void reserve(const FrameSize& size) {
    gaussians.reserve("the frame's tile pairs", size.pair_capacity);
  }
};

/// Sorts the Gaussians of macro-tiles by depth, then by index in the file, and writes the lists of
/// their tiles, the lists' ranges and schedule. Also counts the pairs. Pairs beyond
/// size.pair_capacity are counted but not written. For macro-tiles with less than kUsual Gaussians.
void list_usual(const FrameContext& frame, const FrameSize& size, Scratch& scratch,
                FastPairs& pairs);

/// The same for macro-tiles with at least kUsual Gaussians. Macro-tiles beyond size.macro.capacity
/// list nothing.
void list_whole(const FrameContext& frame, const FrameSize& size, Scratch& scratch,
                FastPairs& pairs, cudaStream_t stream);

/// The same if these macro-tiles are cut into slices. Slices and spilled entries beyond the
/// capacities of size.macro are counted but not listed.
void list_sliced(const FrameContext& frame, const FrameSize& size, Scratch& scratch,
                 FastPairs& pairs, cudaStream_t stream);

}  // namespace qs::cuda::fast
