// SPDX-License-Identifier: MIT
//
// Queues of the Gaussians that wait to be composited, one for each of a warp's sub-tiles, in shared
// memory. All four begin at the same slot, because they advance together.
#pragma once

#include "raster/cuda/common/sub_tiles.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/cuda/fast/column.cuh"

namespace qs::cuda::fast {

constexpr unsigned kLanes = kWarp / kSubTiles;  // of a sub-tile, a column of pixels each
static_assert(kLanes == kSubWidth && kPixels == kSubHeight);

constexpr unsigned kUnroll = 4;  // slots composited per loop iteration
constexpr unsigned kRing = 52;   // slots; with more, fewer warps fit into a multiprocessor
static_assert(kRing % kUnroll == 0 && kRing > kWarp);

/// The slots of one sub-tile, circular. A slot without a Gaussian has c0 = -inf, so alpha is 0.
struct Ring {
  float4 shape[kRing], rest[kRing];  // as in Staged
  float blue[kRing];
  float4 gap;  // the rings of a warp begin in different banks

  __device__ void store(unsigned slot, const Staged& staged) {
    shape[slot] = staged.shape;
    rest[slot] = staged.rest;
    blue[slot] = staged.blue;
  }
};
static_assert(sizeof(Ring) % 128 != 0 && sizeof(Ring) % 16 == 0);

/// A warp's rings. All its lanes call the functions together, with equal lengths.
template <bool kMaps>
struct Rings {
  Ring rings[kSubTiles];
  std::uint32_t places[kMaps ? kSubTiles : 1][kMaps ? kRing : 1];  // of the slots' list entries

  static __device__ unsigned wrapped(unsigned slot) { return slot < kRing ? slot : slot - kRing; }

  /// Empty slots are read too, so they must hold finite values.
  __device__ void clear() {
    constexpr unsigned kVectors = kSubTiles * (sizeof(Ring) / sizeof(float4));
    auto* const all = reinterpret_cast<float4*>(rings);
    for (unsigned i = lane_index(); i < kVectors; i += kWarp) all[i] = float4{0, 0, 0, 0};
    __syncwarp();
  }

  /// Empties the slots of this lane's sub-tile from `length` to `end`, counted from `head`.
  __device__ void pad(unsigned head, unsigned length, unsigned end) {
    const unsigned lane = lane_index();
#pragma unroll 1
    for (unsigned i = length + lane % kLanes; i < end; i += kLanes)
      rings[lane / kLanes].shape[wrapped(head + i)].x = -INFINITY;
  }
};

}  // namespace qs::cuda::fast
