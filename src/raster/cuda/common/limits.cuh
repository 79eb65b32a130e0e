// SPDX-License-Identifier: MIT
//
// Limits of the current device, from which grids and buffers get their sizes, and of the pairs of a
// view. All functions throw Error(device).
#pragma once

#include <cstdint>

namespace qs::cuda {

/// The number of multiprocessors. Kernels whose blocks share work start a few blocks for each.
unsigned multiprocessors();

/// The largest number of entries that a block can sort, at least kUsualSort, see block_sort.cuh.
std::uint32_t most_in_shared_memory();

/// Pairs are counted in 64 bits but indexed with 31.
inline constexpr std::uint64_t kMaxPairs = 0x7fffffff;

/// Throws if a view lists more tile pairs than can be indexed.
void require_indexable(std::uint64_t tile_pairs);

}  // namespace qs::cuda
