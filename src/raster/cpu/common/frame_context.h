// SPDX-License-Identifier: MIT
//
// The inputs that every stage of the CPU backend reads.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <stop_token>

#include "base/parallel.h"
#include "raster/api/renderer.h"

namespace qs::cpu {

struct FrameContext {
  const GaussianCloud& cloud;
  const Camera& camera;
  const RenderSettings& settings;
  TileGrid grid;
  ThreadPool& pool;
  std::stop_token stop;
  std::function<void(float fraction)> report = {};  ///< see Renderer::report_frames_to()
  const GaussianSet* drawn = nullptr;               ///< see Renderer::set_drawn(); null: all
  std::optional<PixelBox> only = {};  ///< the only pixels whose lists are used; unset: all

  /// Index of a pixel in a map of the image.
  std::size_t pixel(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
           static_cast<std::size_t>(x);
  }
  bool draws(std::size_t gaussian) const { return drawn == nullptr || (*drawn)[gaussian]; }
  int sh_degree() const { return std::min(settings.sh_degree, cloud.sh_degree); }
  bool antialiased() const { return settings.antialiased.value_or(cloud.antialiased); }
  FootprintRules rules() const { return footprint_rules(settings, antialiased()); }
  /// A pixel stops before its transmittance falls below this.
  double least_transmittance() const {
    return is_solid(settings.style) ? kSolidTransmittanceMin : fp64::kTransmittanceMin;
  }

  /// Runs a parallel loop; throws Cancelled when the frame was cancelled.
  template <class Body>
  void for_chunks(std::size_t count, std::size_t grain, const Body& body) const {
    pool.for_chunks(count, grain, [&](std::size_t begin, std::size_t end, int worker) {
      if (stop.stop_requested()) throw Cancelled{};
      body(begin, end, worker);
    });
  }

  /// Like for_chunks(), for the loop that takes most of the frame's time: also reports the progress
  /// of the frame.
  template <class Body>
  void for_frame(std::size_t count, std::size_t grain, const Body& body) const {
    for_chunks(count, grain, [&](std::size_t begin, std::size_t end, int worker) {
      if (worker == 0 && report) report(static_cast<float>(begin) / static_cast<float>(count));
      body(begin, end, worker);
    });
  }
};

// Stage times. Measuring them costs nothing noticeable, so it always happens.

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
