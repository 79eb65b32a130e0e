// SPDX-License-Identifier: MIT
//
// Stage 1 of the fast pipeline, in two kernels: `project` decides what is visible and where,
// `color` evaluates the spherical harmonics and writes what blending reads. The second reads most
// of the scene's bytes and nothing waits for it but blending, so it runs beside binning and
// sorting. A Gaussian keeps its index in the cloud.
#pragma once

#include <algorithm>
#include <bit>

#include "raster/cuda/frame_context.cuh"

namespace qs::cuda::fast {

/// What binning reads of a visible Gaussian: 32 bytes, which lie in one sector. The rest of its
/// footprint follows from it by the same operations, to the bit.
struct alignas(32) Shape {
  glm::vec2 mean_px;
  Covariance2<float> covariance;
  float gamma;
  std::uint32_t lines;  ///< of tiles in the mode's walk; 0 in a mode without one
  std::uint32_t tiles;  ///< in them, > 0

  QS_HD Footprint footprint() const { return make_footprint(mean_px, covariance, gamma); }
};

/// Where a Gaussian counts: an ellipse. In the row v pixels below its mean it spans
/// slope v +- sqrt(half2 - narrowing v^2), if |v| <= y_max. Widened for rounding; what is cut off
/// is the same in every mode, so that lossless modes stay equal to the bit.
struct Reach {
  float y_max;      ///< < 0: nowhere
  float slope;      ///< of the line through the middles of the rows
  float v_extreme;  ///< row in which it reaches furthest to the right; -v_extreme: to the left
  float half2, narrowing;
};

/// What blending reads of a Gaussian: 64 bytes, two sectors.
struct alignas(64) BlendRecord {
  float x, y;              ///< mean_px
  float xx, xy, yy;        ///< log2 alpha = log2_opacity + xx dx^2 + xy dx dy + yy dy^2
  float log2_opacity;      ///< -inf for opacity 0
  float alpha_max;         ///< kAlphaMax, or a little more than the opacity where that is less
  float red, green, blue;  ///< >= 0
  Reach reach;
  float unused;

  Splat splat() const {
    return {{x, y}, {xx, xy, yy}, std::exp2(log2_opacity), {red, green, blue}};
  }
};

/// A key is the bits of a depth less those of the near plane. Positive floats are ordered as their
/// bits are, and few scenes reach so far that the keys' highest digit is not zero.
inline constexpr std::uint32_t kInvisibleKey = 0xffffffffu;

inline std::uint32_t nearest_bits(const Camera& camera) {
  return std::bit_cast<std::uint32_t>(std::max(static_cast<float>(camera.near_depth), 0.0f));
}
inline float depth_of_key(std::uint32_t key, const Camera& camera) {
  return std::bit_cast<float>(key + nearest_bits(camera));
}

struct VisibleView {
  std::uint32_t* depth_keys;  ///< kInvisibleKey = not visible, and the rest undefined
  Shape* shapes;
  BlendRecord* records;
};

struct Visible {
  DeviceBuffer<std::uint32_t> depth_keys;
  DeviceBuffer<Shape> shapes;
  DeviceBuffer<BlendRecord> records;

  void reserve(std::size_t gaussians);
  VisibleView view() { return {depth_keys.data(), shapes.data(), records.data()}; }
};

/// Memory that a kernel makes zero beside its own work.
struct ToClear {
  uint4* words;
  std::size_t count;
};

void project(const FrameContext& frame, Visible& visible, const ToClear& to_clear);
void color(const FrameContext& frame, Visible& visible, cudaStream_t stream);

}  // namespace qs::cuda::fast
