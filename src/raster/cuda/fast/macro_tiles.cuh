// SPDX-License-Identifier: MIT
//
// A macro-tile is a block of kMacroColumns x kMacroRows tiles. The usual way to list a frame's tile
// pairs: `project` appends every visible Gaussian to the macro-tiles that its bounds meet, in any
// order, and list_by_macro_tile() sorts each macro-tile by depth in shared memory and writes the
// lists of its tiles. A view with a macro-tile that shared memory cannot hold is sorted globally
// instead (bin.cuh, sort.cuh). Both give the same lists.
#pragma once

#include "raster/cuda/fast/sort.cuh"

namespace qs::cuda::fast {

/// The largest MacroTiles::capacity on the current device.
std::uint32_t most_per_macro_tile();

/// Sorts the Gaussians of every macro-tile by depth, then by index, and writes the lists of its
/// tiles, their ranges and their schedule. Also counts the pairs. Pairs beyond size.pair_capacity
/// are counted but not written. Macro-tiles that exceed their capacity list nothing.
/// Works in frame.stream, and in `full_stream` if size.has_full_macro_tiles().
void list_by_macro_tile(const FrameContext& frame, const FrameSize& size, Scratch& scratch,
                        TilePairs& pairs, cudaStream_t full_stream);

}  // namespace qs::cuda::fast
