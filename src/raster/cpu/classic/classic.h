// SPDX-License-Identifier: MIT
//
// Pipeline `classic` of the CPU backend: the stages in plain C++, the readable statement of what
// cpu/fast/ does with vectors, and what that is tested against.
#pragma once

#include "raster/cpu/classic/blend.h"

namespace qs::cpu {

class Classic {
 public:
  /// Fills `result`, whose maps are sized, but for the time of the frame.
  void draw(const FrameContext& frame, const Outputs& outputs, Frame& result);

  /// Fills used and used_pairs of a frame that another pipeline drew: its lists are the same.
  void count_used(const FrameContext& frame, Frame& result);

 private:
  Visible visible_;
  DepthOrder order_;
  TileLists lists_;
};

}  // namespace qs::cpu
