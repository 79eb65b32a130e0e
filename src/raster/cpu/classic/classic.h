// SPDX-License-Identifier: MIT
//
// Pipeline `classic` of the CPU backend: the stages in plain C++. Tests compare cpu/fast/ with it,
// and frames that ask for Outputs::used, Outputs::depth or other tile sizes run on it.
#pragma once

#include "raster/cpu/classic/blend.h"
#include "raster/cpu/classic/preprocess.h"
#include "raster/cpu/common/mode_pairs.h"
#include "raster/scene/activated_cloud.h"

namespace qs::cpu {

class Classic {
 public:
  /// Activates `cloud` unless that was done. Call it before the other functions.
  void activate_once(const GaussianCloud& cloud, ThreadPool& pool);

  /// Fills `result`, whose maps already have their sizes, except for depth and the frame's time.
  void draw(const FrameContext& frame, const Outputs& outputs, Frame& result);

  /// Makes the tile lists of a frame that pipeline fast drew; both pipelines have the same lists.
  void list(const FrameContext& frame);

  /// Fills used and used_pairs of a frame after draw() or list().
  void count_used(const FrameContext& frame, Frame& result) const;

  /// Fills depth of a frame after draw() or list().
  void draw_depth(const FrameContext& frame, Frame& result) const;

  /// Adds the counts of every mode for a view to `sums`; needs no frame of it.
  void count_modes(const FrameContext& counted, ModeSums& sums) const;

 private:
  ActivatedCloud active_;
  Visible visible_;
  DepthOrder order_;
  TileLists lists_;
};

}  // namespace qs::cpu
