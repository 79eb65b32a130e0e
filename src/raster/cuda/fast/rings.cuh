// SPDX-License-Identifier: MIT
//
// Queues of the Gaussians that wait to be composited, one for each of a warp's sub-tiles, in shared
// memory. All four begin at the same slot, because they advance together.
#pragma once

#include "raster/cuda/fast/column.cuh"
#include "raster/cuda/fast/preprocess.cuh"
#include "raster/cuda/fast/try.cuh"
#include "raster/cuda/reach.cuh"
#include "raster/cuda/warp.cuh"

namespace qs::cuda::fast {

constexpr unsigned kLanes = kWarp / kSubTiles;  // of a sub-tile, a column of pixels each
static_assert(kLanes == kSubWidth && kPixels == kSubHeight);

constexpr unsigned kUnroll = 4;  // slots composited per loop iteration
constexpr unsigned kRing = QS_TRY_RING;  // slots
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

#if QS_TRY_COPY
/// The next 32 splats of a warp, which are copied from global memory while it composites others.
/// Four lanes copy a splat together, so that a load instruction touches 8 cache lines, not 32. All
/// lanes of the warp call the functions together.
struct AheadSplats {
  static constexpr unsigned kVectors = sizeof(BoundedSplat) / sizeof(float4);
  static_assert(kVectors == 4);

  float4 vectors[kWarp * kVectors];

  /// Must precede the first begin(): earlier copies may not overwrite later ones.
  static __device__ void wait() {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 800
    asm volatile("cp.async.wait_all;" ::: "memory");
#endif
    __syncwarp();
  }

  /// Begins to copy the splat `gaussian` of each lane.
  __device__ void begin(const BoundedSplat* splats, std::uint32_t gaussian) {
    const unsigned lane = lane_index(), part = lane % kVectors;
#pragma unroll
    for (unsigned k = 0; k < kVectors; ++k) {
      const unsigned owner = k * (kWarp / kVectors) + lane / kVectors;
      const std::uint32_t from = __shfl_sync(kAllLanes, gaussian, owner);
      copy(reinterpret_cast<const float4*>(splats + from) + part, &vectors[place(owner, part)]);
    }
  }

  /// Waits for the copies and returns the lane's splat. They may begin again afterwards.
  __device__ BoundedSplat finish() const {
    wait();
    const unsigned lane = lane_index();
    const float4 a = vectors[place(lane, 0)], b = vectors[place(lane, 1)];
    const float4 c = vectors[place(lane, 2)], d = vectors[place(lane, 3)];
    __syncwarp();
    return {a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, {c.z, c.w, d.x, d.y, d.z}, 0};
  }

 private:
  /// Neighbouring lanes access different banks when they copy and when they read.
  static __device__ unsigned place(unsigned owner, unsigned part) {
    return owner * kVectors + (part ^ owner / 2 % kVectors);
  }

  static __device__ void copy(const float4* from, float4* to) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 800
    const auto address = static_cast<unsigned>(__cvta_generic_to_shared(to));
#if QS_TRY_COPY == 2
    asm volatile("cp.async.cg.shared.global [%0], [%1], 16;" ::"r"(address), "l"(from) : "memory");
#else
    asm volatile("cp.async.ca.shared.global [%0], [%1], 16;" ::"r"(address), "l"(from) : "memory");
#endif
#else
    *to = *from;
#endif
  }
};
#endif

/// A warp's rings. All its lanes call the functions together, with equal lengths.
template <bool kMaps>
struct Rings {
  Ring rings[kSubTiles];
  std::uint32_t places[kMaps ? kSubTiles : 1][kMaps ? kRing : 1];  // of the slots' list entries
#if QS_TRY_COPY
  alignas(16) AheadSplats ahead;
#endif

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
    for (unsigned i = length + lane % kLanes; i < end; i += kLanes) {
      rings[lane / kLanes].shape[wrapped(head + i)].x = -INFINITY;
    }
  }
};

}  // namespace qs::cuda::fast
