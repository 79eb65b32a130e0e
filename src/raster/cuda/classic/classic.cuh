// SPDX-License-Identifier: MIT
//
// Pipeline `classic`, the baseline: preprocess, bin, sort and blend as published with 3DGS. The
// host waits for the number of pairs in the middle of a frame.
#pragma once

#include "raster/cuda/common/pixels.cuh"
#include "raster/cuda/common/scan_and_sort.cuh"
#include "raster/cuda/common/stage_clock.cuh"
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

  ClassicVisibleView view() {
    return {tile_counts.data(), depths.data(), footprints.arrays(), splats.data(), counters.data()};
  }
};

/// Stage 1: projects, culls and colours the scene, one thread per Gaussian. Results are indexed as
/// in the cloud. A Gaussian is visible if the frame's culling mode assigns it at least one tile. An
/// invisible Gaussian has tile count 0; its other values are undefined.
void preprocess(const FrameContext& frame, ClassicVisible& visible);

inline constexpr int kDepthBits = 32;  ///< bits of a key's depth

/// Keys are tile << kDepthBits | bits of the depth; values are indices in the cloud, ascending
/// before sort().
struct ClassicPairs {
  SortBuffers buffers;
  DeviceBuffer<std::uint64_t> offsets;  ///< per Gaussian: its first pair; last: number of pairs
  PinnedValue<std::uint64_t> total;     ///< number of pairs, copied to the host
  std::uint32_t count = 0;
  DeviceBuffer<ListRange> ranges;  ///< per tile: its list, after sort()
};

/// Stage 2: lists one (tile, Gaussian) pair for every tile that the culling mode assigns to a
/// visible Gaussian. Waits for the GPU to count the pairs: the only synchronisation within a frame.
/// Throws Error(device) if there are too many pairs to index or to fit into memory.
void bin(const FrameContext& frame, ClassicVisible& visible, ClassicPairs& pairs);

/// Stage 3: sorts the pairs by tile, then by depth, then by index in the cloud, and finds the range
/// of every tile's list.
void sort(const FrameContext& frame, ClassicPairs& pairs);

/// Stage 4: composites the list of every tile, front to back. A tile is one block with one thread
/// per pixel; it loads its list in batches of one Gaussian per thread. Fills the parts of `pixels`
/// that `outputs` requests, and ClassicCounters::max_pairs_in_a_tile.
void blend(const FrameContext& frame, ClassicVisible& visible, const ClassicPairs& pairs,
           const Outputs& outputs, Pixels& pixels);

class ClassicPipeline {
 public:
  /// Enqueues the frame, which fills `pixels`. Throws Error and Cancelled.
  void draw(const FrameContext& frame, const Outputs& outputs, Pixels& pixels, StageClock& clock);

  /// Waits for the frame and fills statistics, pairs, used pairs and trace, as requested.
  void collect(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
               Frame& result);

  /// Enqueues a pass that fills Pixels::depth of the drawn frame.
  void draw_depth(const FrameContext& frame, Pixels& pixels) const;

  /// The lists and the splats of the drawn frame.
  BlendInput<LogSplat> lists(const FrameContext& frame) const;

 private:
  void append_gaussians(const FrameContext& frame, Trace& trace) const;

  PinnedValue<ClassicCounters> counters_;
  ClassicVisible visible_;
  ClassicPairs pairs_;
};

}  // namespace qs::cuda::classic
