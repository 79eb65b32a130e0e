// SPDX-License-Identifier: MIT
//
// Stage 1 of the classic pipeline: projects, culls and colours the scene, one thread per Gaussian.
// Results are indexed as in the cloud. An invisible Gaussian has tile count 0; its other values are
// undefined.
#pragma once

#include "raster/cuda/common/footprints.cuh"
#include "raster/cuda/common/frame_context.cuh"
#include "raster/kernel/blend.h"

namespace qs::cuda::classic {

/// A Gaussian as the blend kernel reads it, with the logarithm of its opacity: one comparison of
/// exponents decides whether alpha reaches 1/255.
struct alignas(16) LogSplat {
  float x, y;          ///< mean_px
  float xx, xy;        ///< log2 alpha = log2_opacity + xx dx^2 + xy dx dy + yy dy^2
  float yy;            ///< see Splat::log2_conic
  float log2_opacity;  ///< -inf for opacity 0
  float red, green;    ///< >= 0
  float blue;
  float unused[3];

  static QS_HD LogSplat of(const Footprint& footprint, glm::vec3 color) {
    constexpr float kGammaToLog2 = static_cast<float>(0.5 * kLog2E);
    const Splat splat = make_splat(footprint, 1.0f, color);
    const glm::vec3 q = splat.log2_conic;
    return {splat.mean_px.x,
            splat.mean_px.y,
            q.x,
            q.y,
            q.z,
            kGammaToLog2 * footprint.gamma - kLog2Of255,
            color.x,
            color.y,
            color.z,
            {}};
  }

  Splat splat() const {
    return {{x, y}, {xx, xy, yy}, std::exp2(log2_opacity), {red, green, blue}};
  }
};

/// Counted by the frame's kernels; reset to zero at the start of preprocess().
struct ClassicCounters {
  std::uint32_t visible;
  std::uint32_t max_pairs_in_a_tile;
};

/// The pointers that kernels use. Passed by value.
struct ClassicVisibleView {
  std::uint32_t* tile_counts;  ///< 0 = not visible; one more element than Gaussians, always 0
  float* depths;               ///< view z
  FootprintArrays footprints;
  LogSplat* splats;
  ClassicCounters* counters;
};

struct ClassicVisible {
  DeviceBuffer<std::uint32_t> tile_counts;
  DeviceBuffer<float> depths;
  FootprintBuffers footprints;
  DeviceBuffer<LogSplat> splats;
  DeviceBuffer<ClassicCounters> counters;

  void reserve(std::size_t gaussians);

  ClassicVisibleView view() {
    return {tile_counts.data(), depths.data(), footprints.arrays(), splats.data(), counters.data()};
  }
};

/// A Gaussian is visible if the frame's culling mode assigns it at least one tile.
void preprocess(const FrameContext& frame, ClassicVisible& visible);

}  // namespace qs::cuda::classic
