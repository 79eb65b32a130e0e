// SPDX-License-Identifier: MIT
//
// Stage 4 of the fast pipeline. Every warp composites half a tile, 16x8 pixels, independently
// (walk.cuh). Long lists are shared by many warps (segments.cuh).
#pragma once

#include <utility>

#include "raster/cuda/common/pixels.cuh"
#include "raster/cuda/fast/list.cuh"
#include "raster/cuda/fast/walk.cuh"

namespace qs::cuda::fast {

/// True if blend_long_lists() composites long lists. A requested map needs one walk through the
/// whole list, so then it does not.
inline bool cuts_long_lists(const Outputs& outputs) {
  return outputs.color && !outputs.evaluated && !outputs.used;
}

/// px^2. Products of exponentials have exponents that grow as footprints become thinner. With this
/// dilation they stay above -90, and floats reach down to -126.
inline constexpr double kLeastDilationOfProducts = kDilation / 2;

/// True if alphas need Rows::exponents: in frames of reduced size, for example.
inline bool has_thin_rows(const RenderSettings& settings) {
  return settings.dilation < kLeastDilationOfProducts;
}

/// The results of stages 1 to 3.
struct ListedTiles {
  const FastVisible& visible;
  const FastPairs& pairs;
  const Scratch& scratch;
};

inline ListInput input_of(const FrameContext& frame, const ListedTiles& listed) {
  return ListInput::of(frame, listed.pairs.gaussians, std::as_const(listed.scratch.ranges),
                       listed.visible.splats);
}

constexpr unsigned kBlendThreads = kHalfTiles * kWarp;
constexpr unsigned kBlendBlocks = 14;  ///< per multiprocessor, to hide latency

/// Fills the parts of `pixels` that `outputs` requests, in tiles without long lists or in all.
/// Runs in `stream`, not in the frame's.
void blend(const FrameContext& frame, const ListedTiles& listed, const Outputs& outputs,
           Pixels& pixels, cudaStream_t stream);

/// Prepares blend_long_lists(). Must precede blend(): a kernel that starts while blend() occupies
/// the GPU waits for its blocks.
void count_long_lists(const FrameContext& frame, const ListedTiles& listed);

/// Fills the image in tiles with long lists. May run concurrently with blend().
void blend_long_lists(const FrameContext& frame, const ListedTiles& listed, const Outputs& outputs,
                      Pixels& pixels);

}  // namespace qs::cuda::fast
