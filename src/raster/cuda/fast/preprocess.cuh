// SPDX-License-Identifier: MIT
//
// Stage 1 of the fast pipeline, in two kernels: `project` decides what is visible and where,
// `color` evaluates the spherical harmonics and writes what blending reads. The second reads most
// of the scene's bytes and nothing waits for it but blending, so it runs beside binning and
// sorting. A Gaussian keeps its index in the cloud.
#pragma once

#include "raster/cuda/frame_context.cuh"

namespace qs::cuda::fast {

/// What binning reads of a visible Gaussian: 32 bytes, which lie in one sector. The rest of its
/// footprint follows from it by the same operations, to the bit.
struct alignas(32) Shape {
  glm::vec2 mean_px;
  Covariance2<float> covariance;
  float gamma;
  float depth;          ///< view z
  std::uint32_t tiles;  ///< of the frame's mode, > 0

  QS_HD Footprint footprint() const { return make_footprint(mean_px, covariance, gamma); }
};

/// What blending reads of a Gaussian.
struct alignas(16) BlendRecord {
  float x, y;              ///< mean_px
  float xx, xy, yy;        ///< log2 alpha = log2_opacity + xx dx^2 + xy dx dy + yy dy^2
  float log2_opacity;      ///< -inf for opacity 0
  float red, green, blue;  ///< >= 0
  float alpha_max;         ///< kAlphaMax, or a little more than the opacity where that is less
  float x_max, y_max;      ///< half extents of the pixels that can count; < 0 where none can

  static constexpr float kLog2Of255 = 7.994353436858858f;
};

/// Order of the bits of positive depths is order of depths. Keys count from the near plane, so that
/// kDepthBits of them reach 128 octaves beyond it; further away depths are one.
inline constexpr int kDepthBits = 30;
inline constexpr std::uint32_t kFarthestKey = (1u << kDepthBits) - 1;
inline constexpr std::uint32_t kInvisibleKey = 0xffffffffu;

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

void project(const FrameContext& frame, Visible& visible);
void color(const FrameContext& frame, Visible& visible, cudaStream_t stream);

}  // namespace qs::cuda::fast
