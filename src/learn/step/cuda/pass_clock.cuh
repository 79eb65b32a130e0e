// SPDX-License-Identifier: MIT
//
// Times of the passes of an iteration on the GPU's clock, read one iteration later, so that the
// host does not wait.
#pragma once

#include <array>
#include <cstdint>

#include "learn/step/training_model.h"
#include "raster/cuda/common/check.cuh"

namespace qs::cuda::train {

class PassClock {
 public:
  PassClock() {
    for (Events& events : events_)
      for (cudaEvent_t& event : events) check(cudaEventCreate(&event), "cudaEventCreate");
  }
  PassClock(const PassClock&) = delete;
  PassClock& operator=(const PassClock&) = delete;
  ~PassClock() {
    for (const Events& events : events_)
      for (const cudaEvent_t event : events) cudaEventDestroy(event);
  }

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
    const Events& events = events_[(iterations_ > 1 ? iterations_ - 2 : 0) % 2];
    check(cudaEventSynchronize(events[kPasses]), "training");
    const auto between = [&events](std::size_t pass) {
      float ms = 0;
      check(cudaEventElapsedTime(&ms, events[pass], events[pass + 1]), "cudaEventElapsedTime");
      return 1e-3 * static_cast<double>(ms);
    };
    return {between(0), between(1), between(2), between(3)};
  }

 private:
  static constexpr std::size_t kPasses = 4;
  using Events = std::array<cudaEvent_t, kPasses + 1>;

  void record(std::size_t event, cudaStream_t stream) {
    check(cudaEventRecord(events_[iterations_ % 2][event], stream), "cudaEventRecord");
  }

  std::array<Events, 2> events_{};  // of iterations with even and odd numbers
  std::uint64_t iterations_ = 0;
};

}  // namespace qs::cuda::train
