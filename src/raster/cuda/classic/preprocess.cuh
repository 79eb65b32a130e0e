// SPDX-License-Identifier: MIT
//
// Stage 1 of the classic pipeline: projects, culls and colours the scene, one thread per Gaussian.
// Results are indexed as in the cloud. An invisible Gaussian has tile count 0; its other values are
// undefined.
#pragma once

#include "raster/cuda/frame_context.cuh"
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

/// Footprints in three arrays with elements of 16, 16 and 8 bytes.
struct FootprintArrays {
  float4* means;   ///< mean x, y, covariance xx, xy
  float4* conics;  ///< covariance yy, conic a, b, c
  float2* levels;  ///< determinant, gamma

  QS_HD Footprint load(std::size_t i) const {
    const float4 m = means[i], c = conics[i];
    const float2 l = levels[i];
    return {{m.x, m.y}, {m.z, m.w, c.x}, {c.y, c.z, c.w}, l.x, l.y};
  }

  QS_HD void store(std::size_t i, const Footprint& f) const {
    const Covariance2<float>& s = f.covariance;
    means[i] = {f.mean_px.x, f.mean_px.y, s.xx, s.xy};
    conics[i] = {s.yy, f.conic.x, f.conic.y, f.conic.z};
    levels[i] = {f.determinant, f.gamma};
  }
};

/// Counted by the frame's kernels; reset to zero at the start of preprocess().
struct Counters {
  std::uint32_t visible;
  std::uint32_t max_pairs_in_a_tile;
};

/// The pointers that kernels use. Passed by value.
struct VisibleView {
  std::uint32_t* tile_counts;  ///< 0 = not visible; one more element than Gaussians, always 0
  float* depths;               ///< view z
  FootprintArrays footprints;
  LogSplat* splats;
  Counters* counters;
};

struct Visible {
  DeviceBuffer<std::uint32_t> tile_counts;
  DeviceBuffer<float> depths;
  DeviceBuffer<float4> means, conics;
  DeviceBuffer<float2> levels;
  DeviceBuffer<LogSplat> splats;
  DeviceBuffer<Counters> counters;

  void reserve(std::size_t gaussians);

  VisibleView view() {
    return {tile_counts.data(),
            depths.data(),
            {means.data(), conics.data(), levels.data()},
            splats.data(),
            counters.data()};
  }
};

/// A Gaussian is visible if the frame's culling mode assigns it at least one tile.
void preprocess(const FrameContext& frame, Visible& visible);

}  // namespace qs::cuda::classic
