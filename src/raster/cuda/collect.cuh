// SPDX-License-Identifier: MIT
//
// Copies what a frame decided to the host, for both pipelines: lists, used pairs and trace.
#pragma once

#include <utility>
#include <vector>

#include "raster/cuda/frame_context.cuh"
#include "raster/cuda/pixels.cuh"

namespace qs::cuda {

inline void append_visible(Trace& trace, std::size_t gaussian, const Footprint& footprint,
                           float depth, const Splat& splat) {
  trace.gaussians.push_back(static_cast<std::uint32_t>(gaussian));
  trace.footprints.push_back(footprint);
  trace.depths.push_back(depth);
  trace.splats.push_back(splat);
}

/// Fills the requested ones of Frame::pairs, used and trace, and waits for them. `list_lengths()`
/// returns the number of pairs per tile, `listed` holds the contiguous lists, and
/// `append_gaussians(trace)` calls append_visible() in the order of the cloud.
template <class ListLengths, class AppendGaussians>
void collect_lists(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
                   const ListLengths& list_lengths, const DeviceBuffer<std::uint32_t>& listed,
                   const AppendGaussians& append_gaussians, Frame& result) {
  if (!outputs.pairs && !outputs.used && !outputs.trace) return;
  std::vector<std::uint32_t> lengths = list_lengths();
  if (outputs.used) result.used = pixels.used_per_tile(lengths, frame.stream);
  if (outputs.trace) {
    Trace& trace = result.trace;
    append_gaussians(trace);
    trace.tile_begin.push_back(0);
    for (const std::uint32_t length : lengths) {
      trace.tile_begin.push_back(trace.tile_begin.back() + length);
    }
    trace.listed = copied(listed.data(), trace.tile_begin.back(), frame.stream);
  }
  if (outputs.pairs) result.pairs = std::move(lengths);
}

}  // namespace qs::cuda
