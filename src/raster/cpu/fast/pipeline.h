// SPDX-License-Identifier: MIT
//
// Pipeline `fast` of the CPU backend: the same decisions and pictures with vectors, by all threads,
// in memory that is kept from frame to frame.
#pragma once

#include "raster/cpu/fast/blend.h"

namespace qs::cpu::fast {

class Pipeline {
 public:
  void upload(const GaussianCloud& cloud, const ActivatedCloud& active, ThreadPool& pool) {
    scene_ = make_scene(cloud, active, pool);
  }

  /// Fills `result`, whose maps are sized, but for the time of the frame. frame.cloud is the one
  /// that was uploaded.
  void draw(const FrameContext& frame, const Outputs& outputs, Frame& result);

 private:
  Scene scene_;
  Visible visible_;
  DepthOrder order_;
  TileLists lists_;
  TileQueue queue_;
};

}  // namespace qs::cpu::fast
