// SPDX-License-Identifier: MIT
//
// Measures a frame on the GPU's clock with events. Only a marked frame has events between its
// stages, because they slow it down.
#pragma once

#include "raster/api/renderer.h"
#include "raster/cuda/common/check.cuh"

namespace qs::cuda {

class StageClock {
 public:
  StageClock() {
    for (cudaEvent_t& event : events_) check(cudaEventCreate(&event), "cudaEventCreate");
  }
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;
  ~StageClock() {
    for (const cudaEvent_t event : events_) cudaEventDestroy(event);
  }

  void begin(bool marked, cudaStream_t stream) {
    marked_ = marked;
    steps_ = 0;
    record(0, stream);
  }

  bool marked() const { return marked_; }

  /// Attributes the work enqueued since begin() or the last end() to `stage`. At most kMaxSteps
  /// calls per frame.
  void end(Stage stage, cudaStream_t stream) {
    if (!marked_) return;
    stages_[steps_] = stage;
    record(++steps_, stream);
  }

  /// Marks the end of the frame.
  void finish(cudaStream_t stream) { record(kLast, stream); }

  /// Waits for the end of the frame, sets frame_ms and adds to stage_ms.
  void read(RenderStats& stats) const {
    check(cudaEventSynchronize(events_[kLast]), "frame");
    stats.frame_ms = between(0, kLast);
    for (int step = 0; step < steps_; ++step)
      stats.stage_ms[static_cast<int>(stages_[step])] += between(step, step + 1);
  }

 private:
  static constexpr int kMaxSteps = 8, kLast = kMaxSteps + 1;

  void record(int event, cudaStream_t stream) {
    check(cudaEventRecord(events_[event], stream), "cudaEventRecord");
  }

  float between(int first, int last) const {
    float ms = 0;
    check(cudaEventElapsedTime(&ms, events_[first], events_[last]), "cudaEventElapsedTime");
    return ms;
  }

  cudaEvent_t events_[kLast + 1] = {};  // event s starts step s
  Stage stages_[kMaxSteps] = {};
  int steps_ = 0;
  bool marked_ = false;
};

}  // namespace qs::cuda
