// SPDX-License-Identifier: MIT
#include <cfloat>

#include <glm/geometric.hpp>

#include "raster/cuda/fast/preprocess.cuh"
#include "raster/kernel/blend.h"
#include "raster/kernel/sh.h"

namespace qs::cuda::fast {
namespace {

struct ProjectInput {
  CloudView cloud;
  View<float> view;
  FootprintRules rules;
  TileGrid grid;
  std::uint32_t nearest_bits;  // of the depth whose key is 0
  ToClear to_clear;
};

__device__ std::uint32_t depth_key(float depth, std::uint32_t nearest_bits) {
  const std::uint32_t bits = __float_as_uint(depth);
  return bits > nearest_bits ? bits - nearest_bits : 0;
}

struct Listed {
  std::uint32_t lines, tiles;
};

template <class P>
__device__ Listed count_lines_and_tiles(const Footprint& footprint, TileGrid grid) {
  if constexpr (requires { P::walk(footprint, grid); }) {
    const auto walk = P::walk(footprint, grid);
    Listed listed{static_cast<std::uint32_t>(walk.lines.size()), 0};
    for_each_line(walk, [&](int, Span span) { listed.tiles += span.size(); });
    return listed;
  } else {
    return {0, count_tiles<P>(footprint, grid)};
  }
}

template <class P>
__global__ void __launch_bounds__(kThreads) project_gaussians(ProjectInput in, VisibleView out) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  for (std::size_t word = i; word < in.to_clear.count; word += gridDim.x * blockDim.x) {
    in.to_clear.words[word] = uint4{0, 0, 0, 0};
  }
  if (i >= in.cloud.count) return;
  Projected projected;
  Listed listed{0, 0};
  if (project(in.view, in.rules, in.cloud.gaussian(i), projected)) {
    listed = count_lines_and_tiles<P>(projected.footprint, in.grid);
  }
  const bool visible = listed.tiles > 0;
  out.depth_keys[i] = visible ? depth_key(projected.depth, in.nearest_bits) : kInvisibleKey;
  if (!visible) return;
  const Footprint& footprint = projected.footprint;
  out.footprints[i] = {footprint.mean_px, footprint.covariance, footprint.gamma, listed.lines,
                       listed.tiles};
}

__device__ AlphaEllipse ellipse_of(const Footprint& footprint) {
  if (!(footprint.gamma > 0.0f)) return {-1, 0, 0, 0, 0};
  constexpr float kWider = 1.0005f, kMarginPx = 0.01f;
  const glm::vec2 max = extents(footprint).max * kWider + kMarginPx;
  const glm::vec3 conic = footprint.conic;
  const float half2 = footprint.gamma / conic.x * (kWider * kWider);
  return {max.y, -conic.y / conic.x, -conic.y / conic.z * max.x, half2, half2 / (max.y * max.y)};
}

/// BoundedSplat::clamp_rows.
__device__ float clamp_rows_of(const Footprint& footprint, float log2_opacity, float y_max) {
  constexpr float kLog2AlphaMax = -0.014499570f;
  constexpr float kRounding = 2e-5f;    // of log2 alpha, per thinness
  constexpr float kTolerance = 0.005f;  // of log2 alpha
  constexpr float kThinnest = 1e5f;     // the determinant is then known to 1 %
  // Where alpha = 0.99 2^-kTolerance, the ellipse of an opaque Gaussian has this part of its size.
  constexpr float kPart = 0.06f, kMarginPx = 0.1f;
  const Covariance2<float>& covariance = footprint.covariance;
  const float thinness = covariance.xx * covariance.yy / footprint.determinant;  // >= 1
  if (!(thinness < kThinnest)) return INFINITY;
  const float rounding = kRounding * thinness;
  if (log2_opacity + fmaxf(rounding, kTolerance) < kLog2AlphaMax) return -1;
  return rounding < kTolerance ? fmaf(kPart, y_max, kMarginPx) : FLT_MAX;
}

__device__ BoundedSplat splat_of(const Footprint& footprint, glm::vec3 color) {
  constexpr float kGammaToLog2 = static_cast<float>(0.5 * kLog2E);
  const Splat splat = make_splat(footprint, 1.0f, color);
  const float log2_opacity = kGammaToLog2 * footprint.gamma - kLog2Of255;
  const AlphaEllipse ellipse = ellipse_of(footprint);
  return {splat.mean_px.x,
          splat.mean_px.y,
          splat.log2_conic.x,
          splat.log2_conic.y,
          splat.log2_conic.z,
          log2_opacity,
          clamp_rows_of(footprint, log2_opacity, ellipse.y_max),
          color.x,
          color.y,
          color.z,
          ellipse,
          0};
}

struct ColorInput {
  CloudView cloud;
  glm::vec3 camera;  // world
  int sh_degree;
};

__global__ void __launch_bounds__(kThreads) color_gaussians(ColorInput in, VisibleView visible) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= in.cloud.count || visible.depth_keys[i] == kInvisibleKey) return;
  const float4 position = in.cloud.positions[i];
  const glm::vec3 direction =
      glm::normalize(glm::vec3(position.x, position.y, position.z) - in.camera);
  const glm::vec3 color =
      sh_color<float>(in.sh_degree, direction, [&](int k) { return in.cloud.coefficient(i, k); });
  visible.splats[i] = splat_of(visible.footprints[i].footprint(), color);
}

}  // namespace

void Visible::reserve(std::size_t gaussians) {
  depth_keys.reserve("the frame's Gaussians", gaussians);
  footprints.reserve("the frame's Gaussians", gaussians);
  splats.reserve("the frame's Gaussians", gaussians);
}

void project(const FrameContext& frame, Visible& visible, const ToClear& to_clear) {
  with_culler(frame.settings.mode, [&]<class P>(P) {
    const FootprintRules rules = frame.rules(P::kKeepsFaint);
    const ProjectInput in{frame.cloud.view(), make_view<float>(frame.camera), rules,
                          frame.grid,         nearest_bits(frame.camera),     to_clear};
    launch("preprocess", project_gaussians<P>, blocks_for(std::max(1u, frame.cloud.count)),
           frame.stream, in, visible.view());
  });
}

void color(const FrameContext& frame, Visible& visible, cudaStream_t stream) {
  const ColorInput in{frame.cloud.view(), make_view<float>(frame.camera).position,
                      frame.sh_degree()};
  launch("preprocess", color_gaussians, blocks_for(std::max(1u, frame.cloud.count)), stream, in,
         visible.view());
}

}  // namespace qs::cuda::fast
