// SPDX-License-Identifier: MIT
//
// Times a frame on the GPU's own clock with events. Only a marked frame has an event between its
// stages: measuring must not slow what is measured.
#pragma once

#include "raster/cuda/check.cuh"
#include "raster/renderer.h"

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
    record(0, stream);
  }

  /// Stages end in the order of the enumeration.
  void end(Stage stage, cudaStream_t stream) {
    const int event = static_cast<int>(stage) + 1;
    if (marked_ || event == kStageCount) record(event, stream);
  }

  /// Waits for the frame's end.
  void read(RenderStats& stats) const {
    check(cudaEventSynchronize(events_[kStageCount]), "frame");
    stats.frame_ms = between(0, kStageCount);
    for (int stage = 0; marked_ && stage < kStageCount; ++stage) {
      stats.stage_ms[stage] = between(stage, stage + 1);
    }
  }

 private:
  void record(int event, cudaStream_t stream) {
    check(cudaEventRecord(events_[event], stream), "cudaEventRecord");
  }

  float between(int first, int last) const {
    float ms = 0;
    check(cudaEventElapsedTime(&ms, events_[first], events_[last]), "cudaEventElapsedTime");
    return ms;
  }

  cudaEvent_t events_[kStageCount + 1] = {};  // event s is the start of stage s
  bool marked_ = false;
};

}  // namespace qs::cuda
