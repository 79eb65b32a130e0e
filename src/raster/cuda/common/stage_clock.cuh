// SPDX-License-Identifier: MIT
//
// Measures a frame on the GPU's clock with events. Only a marked frame has events between its
// stages, because they slow it down.
#pragma once

#include "raster/api/renderer.h"
#include "raster/cuda/common/stream.cuh"

namespace qs::cuda {

class StageClock {
 public:
  void begin(bool marked, cudaStream_t stream) {
    marked_ = marked;
    steps_ = 0;
    events_[0].record(stream);
  }

  /// Attributes the work enqueued since begin() or the last end() to `stage`. At most kMaxSteps
  /// calls per frame.
  void end(Stage stage, cudaStream_t stream) {
    if (!marked_) return;
    stages_[steps_] = stage;
    events_[++steps_].record(stream);
  }

  /// Marks the end of the frame.
  void finish(cudaStream_t stream) { events_[kLast].record(stream); }

  /// Waits for the end of the frame, sets frame_ms and adds to stage_ms.
  void read(RenderStats& stats) const {
    events_[kLast].wait("frame");
    stats.frame_ms = events_[kLast].ms_since(events_[0]);
    for (int step = 0; step < steps_; ++step)
      stats.stage_ms[static_cast<int>(stages_[step])] += events_[step + 1].ms_since(events_[step]);
  }

 private:
  static constexpr int kMaxSteps = 8, kLast = kMaxSteps + 1;

  TimedEvent events_[kLast + 1];  // event s starts step s
  Stage stages_[kMaxSteps] = {};
  int steps_ = 0;
  bool marked_ = false;
};

}  // namespace qs::cuda
