// SPDX-License-Identifier: MIT
//
// The lists of tiles. Gaussians list their pairs in any order of their own, the pairs of each in
// the order of tiles, in every culling mode. A warp shares the tiles of a large Gaussian. Then the
// list of every tile is sorted by depth, then by the Gaussian's index, in the shared memory of a
// block, as pipeline `fast` sorts. So the order of the lists does not depend on the order in which
// threads run.
#pragma once

#include "raster/cuda/common/block_sort.cuh"
#include "raster/cuda/common/footprints.cuh"
#include "raster/cuda/common/schedule.cuh"
#include "raster/kernel/cull/mode.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cuda::diff {

/// The arrays that list_pairs() fills, and the total and the depths that it reads. A kernel
/// parameter.
struct ListArrays {
  const unsigned long long* total;  ///< pairs
  std::uint32_t room;               ///< for pairs; if there are more, nothing is listed
  const std::uint32_t* depth_keys;  ///< per Gaussian: bits of the depth, which is positive
  // Per place.
  std::uint32_t* owners;  ///< its Gaussian
  std::uint32_t* tiles;   ///< its tile, until the lists are sorted
  std::uint32_t* slots;   ///< its index in the tile's list, before that is sorted
  // The lists of all tiles.
  SortEntry* entries;     ///< depths and places, in any order
  std::uint32_t* places;  ///< front to back
  // Per tile.
  std::uint32_t* sizes;
  uint2* ranges;                           ///< its list is [x, y)
  std::uint32_t *class_sizes, *scheduled;  ///< see ScheduleView
  unsigned tile_count;

  __device__ bool fits() const { return *total <= room; }
};

/// Projected Gaussians. A kernel parameter.
struct ListInput {
  std::uint32_t gaussians;
  const std::uint32_t* tile_counts;   ///< 0: not listed
  const std::uint32_t* first_places;  ///< see take_places()
  FootprintArrays footprints;
  TileGrid grid;
  ListArrays out;
};

/// Enqueues the listing of the pairs.
void list_pairs(CullMode mode, const ListInput& in, cudaStream_t stream);

}  // namespace qs::cuda::diff
