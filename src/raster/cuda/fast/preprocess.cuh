// SPDX-License-Identifier: MIT
//
// Stage 1 of the fast pipeline: `project` computes visibility and footprints, and appends the
// visible Gaussians to the macro-tiles that they meet. `color` evaluates the spherical harmonics
// and writes the splats for blending. `color` reads most of the scene's bytes, but only blending
// depends on it, so it runs concurrently with appending large Gaussians and with listing. Blocks of
// Gaussians that the view cannot show are skipped unread.
#pragma once

#include <algorithm>
#include <bit>

#include "raster/cuda/common/frame_context.cuh"
#include "raster/cuda/common/stream.cuh"
#include "raster/cuda/common/sub_tiles.cuh"
#include "raster/cuda/fast/scratch.cuh"

namespace qs::cuda::fast {

/// A visible Gaussian as `color` reads it: 32 bytes, one memory sector. footprint() recomputes the
/// other values bit for bit.
struct alignas(32) PackedFootprint {
  glm::vec2 mean_px;
  Covariance2<float> covariance;
  float gamma;
  glm::vec2 unused;  ///< written too, because a partly written sector is first read

  QS_HD Footprint footprint() const { return make_footprint(mean_px, covariance, gamma); }
};

/// A Gaussian as the blend kernel reads it: 64 bytes, two memory sectors.
struct alignas(64) BoundedSplat {
  float x, y;          ///< mean_px
  float xx, xy, yy;    ///< log2 alpha = log2_opacity + xx dx^2 + xy dx dy + yy dy^2
  float log2_opacity;  ///< -inf for opacity 0
  /// alpha can exceed kAlphaMax only in rows within this distance of the mean; < 0: in no row;
  /// INFINITY: rounding may have broken the conic
  float clamp_rows;
  float red, green, blue;  ///< >= 0
  AlphaEllipse ellipse;
  float unused;

  Splat splat() const {
    return {{x, y}, {xx, xy, yy}, std::exp2(log2_opacity), {red, green, blue}};
  }
};

/// A depth key is the bit pattern of the depth minus the bit pattern of the near plane. Positive
/// floats are ordered like their bit patterns.
inline constexpr std::uint32_t kInvisibleKey = 0xffffffffu;

inline std::uint32_t nearest_bits(const Camera& camera) {
  return std::bit_cast<std::uint32_t>(std::max(static_cast<float>(camera.near_depth), 0.0f));
}
inline float depth_of_key(std::uint32_t key, const Camera& camera) {
  return std::bit_cast<float>(key + nearest_bits(camera));
}

/// The pointers that kernels use. Passed by value.
struct FastVisibleView {
  std::uint8_t* shown;    ///< per block of Gaussians: 0 if the view cannot show any of them
  std::uint32_t* blocks;  ///< the blocks with visible Gaussians, in any order
  /// per place in these blocks; kInvisibleKey = not visible, and the other arrays are undefined
  /// there
  std::uint32_t* depth_keys;
  PackedFootprint* footprints;
  BoundedSplat* splats;
};

struct FastVisible {
  DeviceBuffer<std::uint8_t> shown;
  DeviceBuffer<std::uint32_t> blocks, depth_keys;
  DeviceBuffer<PackedFootprint> footprints;
  DeviceBuffer<BoundedSplat> splats;

  void reserve(std::size_t gaussians);
  FastVisibleView view() {
    return {shown.data(), blocks.data(), depth_keys.data(), footprints.data(), splats.data()};
  }
};

/// The first work of a frame: also clears the frame's counters. Records `footprints_known` when
/// color() may begin, before the large Gaussians are appended.
void project(const FrameContext& frame, const FrameSize& size, FastVisible& visible,
             Scratch& scratch, Event& footprints_known);
void color(const FrameContext& frame, const Scratch& scratch, FastVisible& visible,
           cudaStream_t stream);

}  // namespace qs::cuda::fast
