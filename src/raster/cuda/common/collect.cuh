// SPDX-License-Identifier: MIT
//
// Copies a frame's decisions (lists, used pairs, trace) to the host, for both pipelines.
#pragma once

#include <utility>
#include <vector>

#include "raster/cuda/common/frame_context.cuh"
#include "raster/cuda/common/pixels.cuh"

namespace qs::cuda {

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
                   const ListRange* tile_ranges, const DeviceBuffer<std::uint32_t>& gaussians,
                   const AppendGaussians& append_gaussians, Frame& result) {
  if (!outputs.pairs && !outputs.used && !outputs.trace) return;
  const std::vector<ListRange> ranges =
      copied(tile_ranges, static_cast<std::size_t>(frame.grid.count()), frame.stream);
  if (outputs.used) result.used = pixels.used_per_tile(ranges, frame.stream);
  if (outputs.trace) {
    Trace& trace = result.trace;
    append_gaussians(trace);
    const auto all = copied(gaussians.data(), end_of(ranges), frame.stream);
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
