// SPDX-License-Identifier: MIT
#include <algorithm>
#include <bit>

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
  std::uint32_t nearest_bits;  // of the depth that keys count from
};

__device__ std::uint32_t depth_key(float depth, std::uint32_t nearest_bits) {
  const std::uint32_t bits = __float_as_uint(depth);
  return bits > nearest_bits ? min(bits - nearest_bits, kFarthestKey) : 0;
}

template <class P>
__global__ void __launch_bounds__(kThreads) project_gaussians(ProjectInput in, VisibleView out) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= in.cloud.count) return;
  Projected projected;
  std::uint32_t tiles = 0;
  if (project(in.view, in.rules, in.cloud.gaussian(i), projected)) {
    tiles = count_tiles<P>(projected.footprint, in.grid);
  }
  out.depth_keys[i] = tiles > 0 ? depth_key(projected.depth, in.nearest_bits) : kInvisibleKey;
  if (tiles == 0) return;
  const Footprint& footprint = projected.footprint;
  out.shapes[i] = {footprint.mean_px, footprint.covariance, footprint.gamma, projected.depth,
                   tiles};
}

/// Half extents of the ellipse in which pixels can count, with room for rounding. What is cut off
/// is the same in every mode, so that lossless modes stay equal to the bit.
__device__ glm::vec2 counting_extents(const Footprint& footprint) {
  if (!(footprint.gamma > 0.0f)) return glm::vec2(-1.0f);
  return extents(footprint).max * 1.0005f + 0.01f;
}

__device__ BlendRecord record_of(const Footprint& footprint, glm::vec3 color) {
  constexpr float kGammaToLog2 = static_cast<float>(0.5 * kLog2E);
  constexpr float kRoundingRoom = 1.00001f;
  const Splat splat = make_splat(footprint, 1.0f, color);
  const float log2_opacity = kGammaToLog2 * footprint.gamma - BlendRecord::kLog2Of255;
  const glm::vec2 half = counting_extents(footprint);
  return {splat.mean_px.x,
          splat.mean_px.y,
          splat.log2_conic.x,
          splat.log2_conic.y,
          splat.log2_conic.z,
          log2_opacity,
          color.x,
          color.y,
          color.z,
          fminf(kAlphaMax, exp2f(log2_opacity) * kRoundingRoom),
          half.x,
          half.y};
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
  visible.records[i] = record_of(visible.shapes[i].footprint(), color);
}

}  // namespace

void Visible::reserve(std::size_t gaussians) {
  depth_keys.reserve("the frame's Gaussians", gaussians);
  shapes.reserve("the frame's Gaussians", gaussians);
  records.reserve("the frame's Gaussians", gaussians);
}

void project(const FrameContext& frame, Visible& visible) {
  constexpr float kNearest = 1e-30f;  // where the near plane lies at or behind the camera
  const View<float> view = make_view<float>(frame.camera);
  with_culler(frame.settings.mode, [&]<class P>(P) {
    const FootprintRules rules{P::kKeepsFaint, frame.antialiased(), frame.settings.splat_scale};
    const ProjectInput in{frame.cloud.view(), view, rules, frame.grid,
                          std::bit_cast<std::uint32_t>(std::max(view.near_depth, kNearest))};
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
