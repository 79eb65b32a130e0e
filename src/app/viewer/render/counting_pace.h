// SPDX-License-Identifier: MIT
//
// Decides which frames of a moving camera count the pairs of all modes: so few that counting takes
// at most a tenth of the time of drawing, but at least every kMostFramesAgo-th frame.
#pragma once

#include "raster/api/renderer.h"

namespace qs {

class CountingPace {
 public:
  /// A frame was drawn. `counted`: it counted the pairs.
  void learn(const RenderStats& stats, bool counted);

  /// True if the next frame counts.
  bool counts_next() const { return uncounted_ + 1 >= period_; }

 private:
  int period_ = 1;     // every n-th frame counts
  int uncounted_ = 0;  // frames since the last count
};

}  // namespace qs
