// SPDX-License-Identifier: MIT
//
// Stage times. Measuring them costs nothing noticeable, so it always happens.
#pragma once

#include <chrono>

#include "raster/api/renderer.h"

namespace qs::cpu {

class Stopwatch {
 public:
  float ms() const {
    return std::chrono::duration<float, std::milli>(std::chrono::steady_clock::now() - start_)
        .count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Runs work() and stores its time.
template <class Work>
void timed(Stage stage, RenderStats& stats, const Work& work) {
  const Stopwatch clock;
  work();
  stats.stage_ms[static_cast<int>(stage)] = clock.ms();
}

}  // namespace qs::cpu
