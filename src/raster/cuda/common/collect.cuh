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

/// The lists of a pipeline.
template <class Ranges, class AppendGaussians>
struct FrameLists {
  Ranges ranges;  ///< () returns the range of each tile's list in `gaussians`
  const DeviceBuffer<std::uint32_t>& gaussians;
  AppendGaussians append_gaussians;  ///< (trace) calls append_visible() in the order of the cloud
};
template <class Ranges, class AppendGaussians>
FrameLists(Ranges, const DeviceBuffer<std::uint32_t>&, AppendGaussians)
    -> FrameLists<Ranges, AppendGaussians>;

/// Fills Frame::pairs, used and trace as requested, and waits for them.
template <class Ranges, class AppendGaussians>
void collect_lists(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
                   const FrameLists<Ranges, AppendGaussians>& lists, Frame& result) {
  if (!outputs.pairs && !outputs.used && !outputs.trace) return;
  const std::vector<ListRange> ranges = lists.ranges();
  if (outputs.used) result.used = pixels.used_per_tile(ranges, frame.stream);
  if (outputs.trace) {
    Trace& trace = result.trace;
    lists.append_gaussians(trace);
    const auto all = copied(lists.gaussians.data(), end_of(ranges), frame.stream);
    trace.tile_begin.push_back(0);
    for (const ListRange& range : ranges) {
      trace.listed.insert(trace.listed.end(), all.begin() + range.begin, all.begin() + range.end);
      trace.tile_begin.push_back(trace.tile_begin.back() + range.size());
    }
  }
  if (outputs.pairs) {
    for (const ListRange& range : ranges) result.pairs.push_back(range.size());
  }
}

}  // namespace qs::cuda
