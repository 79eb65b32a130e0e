// SPDX-License-Identifier: MIT
//
// A segment of a tile's list in the shared memory of a block. It finds the Gaussians that a warp
// has to composite, and computes their contribution to a pixel. The forward and the backward pass
// must agree on both, so they share this code.
#pragma once

#include <glm/vec2.hpp>

#include "learn/diff/cuda/tiles.cuh"
#include "learn/diff/strided_arrays.h"
#include "raster/cuda/common/flush.cuh"
#include "raster/cuda/common/sub_tiles.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/kernel/blend.h"

namespace qs::cuda::diff {

/// The contribution of a Gaussian to a pixel: composite() of the CPU with fewer instructions. The
/// backend is built without contraction, so multiplications and additions are fused explicitly.
struct Contribution {
  float dx, dy;     ///< offset from the mean to the pixel
  float unclamped;  ///< alpha before the clamp at kAlphaMax
  bool counts;      ///< alpha is at least 1/255

  float4 light;  ///< z, w = red, green
  float alpha, blue;

  /// The transmittance behind the Gaussian.
  __device__ float behind(float transmittance) const {
    return fmaf(-alpha, transmittance, transmittance);
  }
};

/// Clamps alpha by the rules of a caller. The Gaussian does not count if it is then below 1/255.
__device__ inline void limit_alpha(const PixelRules<float>& rules, Contribution& by) {
  by.alpha = fminf(by.unclamped, rules.alpha_max);
  by.counts = by.counts && by.alpha >= kAlphaMin;
}

/// View z and 1 / z of a segment's Gaussians; nothing unless `kExist`.
template <bool kExist>
struct SharedDepths {
  glm::vec2 values[kExist ? kSegment : 1];

  /// Loads them as SharedSegment::load() does, from the depths of all Gaussians.
  __device__ void load(const TilesView& in, const float* depths, std::uint32_t first,
                       std::uint32_t size) {
    if constexpr (kExist) {
      if (threadIdx.x >= size) return;
      const float z = depths[in.owners[in.places[first + threadIdx.x]]];
      values[threadIdx.x] = {z, 1 / z};
    }
  }
};

/// Adds z and 1 / z of an entry to their sums.
__device__ inline glm::vec2 sum_by_weight(const glm::vec2& sums, float weight,
                                          const SharedDepths<true>& depths, std::uint32_t entry) {
  const glm::vec2 values = depths.values[entry];
  return {fmaf(weight, values.x, sums.x), fmaf(weight, values.y, sums.y)};
}

struct SharedSegment {
  // Records of 36 bytes, read in three instructions.
  float4 shapes[kSegment];  ///< mean x, y; log2_conic x, y
  float4 lights[kSegment];  ///< log2_conic z, opacity, red, green
  float blues[kSegment];
  std::uint8_t warps[kSegment];  ///< bit w: the Gaussian may reach a pixel of warp w

  /// Loads the pairs [first, first + size) of a tile's list. `colors`, three per Gaussian, take the
  /// place of the splats'. All threads of the block call it; a barrier must follow.
  __device__ void load(const TilesView& in, std::uint32_t tile, std::uint32_t first,
                       std::uint32_t size, const qs::diff::Rows<const float>& colors = {}) {
    const unsigned thread = threadIdx.x;
    if (thread >= size) return;
    const std::uint32_t gaussian = in.owners[in.places[first + thread]];
    const ListedSplat& listed = in.splats[gaussian];
    const Splat& splat = listed.splat;
    const glm::vec3 color = colors ? colors.vec3(gaussian) : splat.color;
    shapes[thread] = {splat.mean_px.x, splat.mean_px.y, splat.log2_conic.x, splat.log2_conic.y};
    lights[thread] = {splat.log2_conic.z, splat.opacity, color.x, color.y};
    blues[thread] = color.z;
    unsigned bits = 0;
#pragma unroll
    for (unsigned half = 0; half < kHalfTiles; ++half) {
      const Reach reach(listed.ellipse,
                        static_cast<float>(in.left_of(tile)) - listed.splat.mean_px.x,
                        static_cast<float>(in.top_of(tile)) - listed.splat.mean_px.y +
                            static_cast<float>(half * kHalfTileHeight));
#pragma unroll
      for (unsigned s = 0; s < kSubTiles; ++s)
        if (reach.reached[s]) bits |= 1u << (half * kSubTiles + s);
    }
    warps[thread] = static_cast<std::uint8_t>(bits);
  }

  /// The contribution of an entry to pixel (x, y). It does not count if it is NaN.
  __device__ Contribution contribution(std::uint32_t entry, float x, float y) const {
    const float4 shape = shapes[entry], light = lights[entry];
    const float dx = x - shape.x, dy = y - shape.y;
    const float power = fmaf(fmaf(shape.z, dx, shape.w * dy), dx, light.x * dy * dy);
    const float unclamped = light.y * exp2_flush(power);
    const bool counts = power <= 0.0f && unclamped >= kAlphaMin;
    return {dx, dy, unclamped, counts, light, fminf(unclamped, kAlphaMax), blues[entry]};
  }

  /// The splat of an entry.
  __device__ Splat splat(std::uint32_t entry) const {
    const float4 shape = shapes[entry], light = lights[entry];
    return {
        {shape.x, shape.y}, {shape.z, shape.w, light.x}, light.y, {light.z, light.w, blues[entry]}};
  }

  /// Bit k is set if entry group + k is below `size` and may reach a pixel of this warp. All lanes
  /// call it.
  __device__ unsigned reaching(std::uint32_t group, std::uint32_t size) const {
    const std::uint32_t entry = group + lane_index();
    const unsigned warp = threadIdx.x / kWarp;
    return __ballot_sync(kAllLanes, entry < size && (warps[entry] >> warp & 1) != 0);
  }
};

}  // namespace qs::cuda::diff
