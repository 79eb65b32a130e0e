// SPDX-License-Identifier: MIT
//
// Pipeline `fast` of the CPU backend: the results of `classic` with vector code on all threads.
// Buffers are reused from frame to frame.
#pragma once

#include "raster/cpu/common/mode_pairs.h"
#include "raster/cpu/fast/blend.h"

namespace qs::cpu::fast {

class FastPipeline {
 public:
  void upload(SceneBlocks scene) { scene_ = std::move(scene); }

  /// Fills `result`, whose maps already have their sizes, except for the frame's time. The uploaded
  /// scene was made of frame.cloud.
  void draw(const FrameContext& frame, const Outputs& outputs, Frame& result);

  /// Adds the counts of every mode for a view to `sums`; needs no frame of it.
  void count_modes(const FrameContext& counted, ModeSums& sums) const;

 private:
  SceneBlocks scene_;
  FastVisible visible_;
  Bands bands_;
  TileLists lists_;
  TileQueue queue_;
};

}  // namespace qs::cpu::fast
