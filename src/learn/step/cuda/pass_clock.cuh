// SPDX-License-Identifier: MIT
//
// Times of the passes of an iteration on the GPU's clock, read one iteration later, so that the
// host does not wait.
#pragma once

#include <cstdint>

#include "learn/step/training_model.h"
#include "raster/cuda/common/stream.cuh"

namespace qs::cuda::train {

class PassClock {
 public:
  /// Begins an iteration. An iteration that did not reach its last pass is discarded.
  void begin(cudaStream_t stream) { record(0, stream); }
  /// Marks that pass 0, 1, 2 or 3 was enqueued.
  void end(std::size_t pass, cudaStream_t stream) {
    record(pass + 1, stream);
    if (pass + 1 == kPasses) ++iterations_;
  }

  /// Times of the iteration before the last iteration, or of the only iteration. Waits until its
  /// passes have run.
  qs::train::PassSeconds seconds() const {
    const TimedEvent* const events = events_[(iterations_ > 1 ? iterations_ - 2 : 0) % 2];
    events[kPasses].wait("training");
    const auto seconds_of = [events](std::size_t pass) {
      return 1e-3 * static_cast<double>(events[pass + 1].ms_since(events[pass]));
    };
    return {seconds_of(0), seconds_of(1), seconds_of(2), seconds_of(3)};
  }

 private:
  static constexpr std::size_t kPasses = 4;

  void record(std::size_t event, cudaStream_t stream) {
    events_[iterations_ % 2][event].record(stream);
  }

  TimedEvent events_[2][kPasses + 1];  // of iterations with even and odd numbers
  std::uint64_t iterations_ = 0;
};

}  // namespace qs::cuda::train
