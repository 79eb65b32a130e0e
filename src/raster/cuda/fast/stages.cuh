// SPDX-License-Identifier: MIT
//
// The stages of the fast pipeline. `frame` is the frame whose memory `scratch` is.
#pragma once

#include "raster/cuda/common/stream.cuh"
#include "raster/cuda/fast/scratch.cuh"

namespace qs::cuda::fast {

// Stage 1: `project` computes visibility and footprints, and appends the visible Gaussians to the
// macro-tiles that they meet. `color` evaluates the spherical harmonics and writes the splats for
// blending. `color` reads most of the scene's bytes, but only blending depends on it, so it runs
// concurrently with appending large Gaussians and with listing. Blocks of Gaussians that the view
// cannot show are skipped unread.

/// The first work of a frame: also clears the frame's counters. Records `footprints_known` when
/// color() may begin, before the large Gaussians are appended.
void project(const FrameContext& frame, Scratch& scratch, const OcclusionView& occlusion,
             Event& footprints_known);
void color(const FrameContext& frame, const Scratch& scratch, cudaStream_t stream);

// Stages 2 and 3: the lists of tiles. Every macro-tile is sorted by depth in the shared memory of a
// block, which then writes the lists of its tiles. Full macro-tiles are cut into slices first
// (slices.cu).

/// Sorts the Gaussians of macro-tiles by depth, then by index in the file, and writes the lists of
/// their tiles, the lists' ranges and schedule. Also counts the pairs. Pairs beyond
/// FrameSize::pair_capacity are counted but not written. For macro-tiles with less than kUsual
/// Gaussians.
void list_usual(const Scratch& scratch, cudaStream_t stream);

/// The same for macro-tiles with at least kUsual Gaussians. Macro-tiles beyond MacroSize::capacity
/// list nothing.
void list_whole(const Scratch& scratch, cudaStream_t stream);

/// The same if these macro-tiles are cut into slices. Slices and spilled entries beyond the
/// capacities of MacroSize are counted but not listed.
void list_sliced(const Scratch& scratch, cudaStream_t stream);

// Stage 4: every warp composites half a tile, 16x8 pixels, independently (walk.cuh). Long lists are
// shared by many warps (long_lists.cu).

/// True if long lists are cut. A requested map needs one walk through the whole list, so then they
/// are not.
inline bool cuts_long_lists(const Outputs& outputs) {
  return outputs.color && !outputs.evaluated && !outputs.used;
}

/// px^2. Products of exponentials have exponents that grow as footprints become thinner. With this
/// dilation they stay above -90, and floats reach down to -126.
inline constexpr double kLeastDilationOfProducts = kDilation / 2;

/// True if alphas need Rows::exponents: in frames of reduced size, for example. The edges of solid
/// ellipses are thin.
inline bool has_thin_rows(const RenderSettings& settings) {
  return settings.dilation < kLeastDilationOfProducts || is_solid(settings.style);
}

constexpr unsigned kBlendThreads = kHalfTiles * kWarp;
constexpr unsigned kBlendBlocks = 14;  ///< per multiprocessor, to hide latency

/// Fills the parts of `pixels` that `outputs` requests, in tiles whose lists are not cut or in all.
/// Runs in `stream`, not in the frame's.
void blend(const FrameContext& frame, const Scratch& scratch, const Outputs& outputs,
           Pixels& pixels, const OcclusionView& occlusion, cudaStream_t stream);

/// Fills the image in tiles whose lists are cut. May run concurrently with blend().
void blend_long_lists(const FrameContext& frame, const Scratch& scratch, const Outputs& outputs,
                      Pixels& pixels, const OcclusionView& occlusion);

}  // namespace qs::cuda::fast
