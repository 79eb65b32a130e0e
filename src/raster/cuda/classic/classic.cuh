// SPDX-License-Identifier: MIT
//
// Pipeline `classic`, the baseline: preprocess, bin, sort and blend as published with 3DGS, each in
// the file of its name. The host waits for the number of pairs in the middle of a frame.
#pragma once

#include "raster/cuda/classic/blend.cuh"
#include "raster/cuda/common/stage_clock.cuh"

namespace qs::cuda::classic {

class ClassicPipeline {
 public:
  /// Enqueues the frame, which fills `pixels`. Throws Error and Cancelled.
  void draw(const FrameContext& frame, const Outputs& outputs, Pixels& pixels, StageClock& clock);

  /// Waits for the frame and fills statistics, pairs, used pairs and trace, as requested.
  void collect(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
               Frame& result);

  /// Enqueues a pass that fills Pixels::depth of the drawn frame.
  void draw_depth(const FrameContext& frame, Pixels& pixels) const;

 private:
  void append_gaussians(const FrameContext& frame, Trace& trace) const;

  PinnedValue<ClassicCounters> counters_;
  ClassicVisible visible_;
  ClassicPairs pairs_;
  TileLists lists_;
};

}  // namespace qs::cuda::classic
