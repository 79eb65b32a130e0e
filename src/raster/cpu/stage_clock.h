// SPDX-License-Identifier: MIT
//
// Times of stages. They cost nothing that could be measured, so they are always taken.
#pragma once

#include <chrono>

#include "raster/renderer.h"

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

template <class Work>
void timed(Stage stage, RenderStats& stats, const Work& work) {
  const Stopwatch clock;
  work();
  stats.stage_ms[static_cast<int>(stage)] = clock.ms();
}

}  // namespace qs::cpu
