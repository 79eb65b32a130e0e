// SPDX-License-Identifier: MIT
//
// Pipeline `classic`: preprocess, bin, sort, blend as published with 3DGS, each in the file of its
// name. It is the baseline, and waits for the number of pairs in the middle of a frame.
#pragma once

#include "raster/cuda/classic/blend.cuh"
#include "raster/cuda/stage_clock.cuh"

namespace qs::cuda {

class ClassicPipeline {
 public:
  /// Fills `pixels`. Throws Error and Cancelled.
  void draw(const FrameContext& frame, const Outputs& outputs, Pixels& pixels, StageClock& clock);

  /// Waits for the drawn frame: statistics, pairs, used pairs and trace.
  void collect(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
               Frame& result);

 private:
  void collect_trace(const FrameContext& frame, Frame& result) const;
  std::vector<std::uint32_t> list_lengths(const FrameContext& frame) const;

  PinnedValue<Counters> counters_;
  Visible visible_;
  TilePairs pairs_;
  TileLists lists_;
};

}  // namespace qs::cuda
