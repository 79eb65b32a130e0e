// SPDX-License-Identifier: MIT
//
// The lists of the tiles of a view, as kernels read them, the division of lists into segments, and
// the listing.
//
// Gaussians list their pairs in any order of their own, the pairs of each in the order of tiles, in
// every culling mode. A warp shares the tiles of a large Gaussian. Then the list of every tile is
// sorted by depth, then by the Gaussian's index, in the shared memory of a block, as pipeline
// `fast` sorts. So the order of the lists does not depend on the order in which threads run.
#pragma once

#include <glm/vec2.hpp>

#include "raster/cuda/common/block_sort.cuh"
#include "raster/cuda/common/footprints.cuh"
#include "raster/cuda/common/schedule.cuh"
#include "raster/cuda/common/sub_tiles.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/kernel/blend.h"
#include "raster/kernel/cull/mode.h"
#include "raster/kernel/hd.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cuda::diff {

inline constexpr unsigned kTilePixels = kTileSize * kTileSize;
inline constexpr unsigned kSegment = kTilePixels;  ///< Gaussians: one per thread of a tile
inline constexpr std::uint32_t kNoTile = 0xffffffffu;

/// The first segment of a tile whose list begins at pair `begin`. Segments of different tiles never
/// overlap, because a list that begins at b and has n pairs needs ceil(n / 256) segments, at most
/// floor((b + n) / 256) - floor(b / 256) + 1. So the tiles need no prefix sum.
QS_HD std::uint32_t first_segment(std::uint32_t begin, std::uint32_t tile) {
  return begin / kSegment + tile;
}

/// Segments of all tiles, with the segments that no list needs.
inline std::uint32_t segments_of(std::uint32_t pairs, unsigned tiles) {
  return pairs / kSegment + tiles;
}

/// A visible Gaussian.
struct alignas(16) ListedSplat {
  Splat splat;
  AlphaEllipse ellipse;
};

/// The depths of Gaussians, and the arrays of their sums, which blend_tiles() fills. All are null
/// without depths. Passed by value.
struct DepthArrays {
  const float* z;                ///< per Gaussian
  glm::vec2* states;             ///< the sums of z and 1 / z so far, as BlendTarget::states
  float *depth, *inverse_depth;  ///< per pixel: the sums by weight
};

/// The pixels of the tiles and their lists, as kernels read them. Passed by value.
struct TilesView {
  const uint2* ranges;          ///< per tile: its list in `places`
  const std::uint32_t* places;  ///< places of the pairs in the lists of all tiles, front to back
  const std::uint32_t* owners;  ///< per place: its Gaussian
  const ListedSplat* splats;    ///< per Gaussian
  int columns;                  ///< columns of the tile grid
  int width, height;            ///< px

  /// Coordinates of the first pixel of a tile.
  __device__ int left_of(std::uint32_t tile) const {
    return static_cast<int>(tile) % columns * kTileSize;
  }
  __device__ int top_of(std::uint32_t tile) const {
    return static_cast<int>(tile) / columns * kTileSize;
  }
  /// Coordinates of a thread's pixel. A warp has 8x4 pixels.
  __device__ int x_of(std::uint32_t tile, unsigned thread) const {
    return left_of(tile) + static_cast<int>(thread / 32 % 2 * 8 + thread % 8);
  }
  __device__ int y_of(std::uint32_t tile, unsigned thread) const {
    return top_of(tile) + static_cast<int>(thread / 64 * 4 + thread / 8 % 4);
  }
  __device__ bool contains(int x, int y) const { return x < width && y < height; }
  __device__ std::size_t index_of(int x, int y) const {
    return static_cast<std::size_t>(y) * width + x;
  }
};

/// The first of `tiles` neighbouring places for the pairs of a thread's Gaussian; undefined for 0
/// tiles. All threads of a block call it. Adds the block's tiles to `*pairs`.
__device__ inline std::uint32_t take_places(unsigned tiles, unsigned long long* pairs) {
  __shared__ unsigned long long first;
  const auto sum = sum_of_block<kThreads>(static_cast<unsigned long long>(tiles));
  if (threadIdx.x == 0) first = sum.total > 0 ? atomicAdd(pairs, sum.total) : 0;
  __syncthreads();
  return static_cast<std::uint32_t>(first + sum.before);
}

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
