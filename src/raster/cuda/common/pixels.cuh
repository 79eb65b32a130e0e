// SPDX-License-Identifier: MIT
//
// A frame's image and maps on the device, as both pipelines write them: every target (host image,
// GL texture) is filled from them.
// The blend kernels of both pipelines take BlendInput and BlendOutput.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "raster/cuda/common/frame_context.cuh"
#include "raster/cuda/common/stream.cuh"

namespace qs::cuda {

/// The range [begin, end) of a tile's list in the lists of all tiles.
struct ListRange {
  std::uint32_t begin, end;
  QS_HD std::uint32_t size() const { return end - begin; }
};

/// The number of pairs up to the last list.
inline std::size_t end_of(const std::vector<ListRange>& ranges) {
  std::size_t end = 0;
  for (const ListRange& range : ranges) end = std::max<std::size_t>(end, range.end);
  return end;
}

struct Pixels {
  DeviceBuffer<float> color;              ///< height x width x 3
  DeviceBuffer<std::uint32_t> evaluated;  ///< height x width
  DeviceBuffer<std::uint8_t> used;        ///< per listed pair: 1 = a pixel blended it
  DeviceBuffer<float> depth;              ///< alpha, expected and median depth, one after the other

  static std::size_t count_of(const Camera& camera) {
    return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  }

  /// Makes room for the image and the maps of pixels, if `outputs` requests them.
  void reserve(const Camera& camera, const Outputs& outputs) {
    const std::size_t count = count_of(camera);
    if (outputs.color) color.reserve("the frame's image", 3 * count);
    if (outputs.evaluated) evaluated.reserve("the frame's evaluated pairs", count);
    if (outputs.depth) depth.reserve("the frame's depth", 3 * count);
  }

  /// Makes room for the marks of `pairs` pairs, if `outputs` requests them; clear_used() enqueues
  /// their reset.
  void reserve_used(const Outputs& outputs, std::size_t pairs) {
    if (outputs.used) used.reserve("the frame's used pairs", pairs);
  }
  void clear_used(const Outputs& outputs, std::size_t pairs, cudaStream_t stream) {
    if (outputs.used && pairs > 0) set_zero("blend", used.data(), pairs, stream);
  }

  /// Number of marked pairs per tile.
  std::vector<std::uint32_t> used_per_tile(const std::vector<ListRange>& ranges,
                                           cudaStream_t stream) const {
    const std::vector<std::uint8_t> marks = copied(used.data(), end_of(ranges), stream);
    std::vector<std::uint32_t> sums;
    for (const ListRange& range : ranges)
      sums.push_back(std::accumulate(marks.begin() + range.begin, marks.begin() + range.end,
                                     std::uint32_t{0}));
    return sums;
  }
};

/// `Range` locates a tile's list; `Entry` is the record that a pipeline blends per Gaussian.
template <class Entry>
struct BlendInput {
  const ListRange* ranges;         ///< per tile: its list in `gaussians`
  const std::uint32_t* gaussians;  ///< the lists of all tiles, front to back: indices into `splats`
  const Entry* splats;
  int columns, rows;  ///< columns and rows of the tile grid
  int width, height;  ///< px
  glm::vec3 background;
  float most_log2_alpha;  ///< more comes from a conic that rounding broke

  static BlendInput of(const FrameContext& frame, const ListRange* ranges,
                       const std::uint32_t* gaussians, const Entry* splats) {
    return {ranges,
            gaussians,
            splats,
            frame.grid.columns,
            frame.grid.rows,
            frame.camera.width,
            frame.camera.height,
            frame.settings.background,
            is_solid(frame.settings.style) ? kSolidLog2 + 1 : kLog2Slack};
  }
};

/// The parts of Pixels that a kernel writes; null: not requested.
struct BlendOutput {
  float* color;
  std::uint32_t* evaluated;
  std::uint8_t* used;

  static BlendOutput of(Pixels& pixels, const Outputs& outputs) {
    return {outputs.color ? pixels.color.data() : nullptr,
            outputs.evaluated ? pixels.evaluated.data() : nullptr,
            outputs.used ? pixels.used.data() : nullptr};
  }
};

inline void append_visible(Trace& trace, std::size_t gaussian, const Footprint& footprint,
                           float depth, const Splat& splat) {
  trace.gaussians.push_back(static_cast<std::uint32_t>(gaussian));
  trace.footprints.push_back(footprint);
  trace.depths.push_back(depth);
  trace.splats.push_back(splat);
}

/// Fills Frame::pairs, used and trace as requested, and waits for them. `tile_ranges` has the range
/// of each tile's list in `gaussians`. append_gaussians(trace) calls append_visible() in the order
/// of the cloud.
template <class AppendGaussians>
void collect_lists(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
                   const ListRange* tile_ranges, const std::uint32_t* gaussians,
                   const AppendGaussians& append_gaussians, Frame& result) {
  if (!outputs.pairs && !outputs.used && !outputs.trace) return;
  const std::vector<ListRange> ranges =
      copied(tile_ranges, static_cast<std::size_t>(frame.grid.count()), frame.stream);
  if (outputs.used) result.used = pixels.used_per_tile(ranges, frame.stream);
  if (outputs.trace) {
    Trace& trace = result.trace;
    append_gaussians(trace);
    const auto all = copied(gaussians, end_of(ranges), frame.stream);
    trace.tile_begin.push_back(0);
    for (const ListRange& range : ranges) {
      trace.listed.insert(trace.listed.end(), all.begin() + range.begin, all.begin() + range.end);
      trace.tile_begin.push_back(trace.tile_begin.back() + range.size());
    }
  }
  if (outputs.pairs)
    for (const ListRange& range : ranges) result.pairs.push_back(range.size());
}

}  // namespace qs::cuda
