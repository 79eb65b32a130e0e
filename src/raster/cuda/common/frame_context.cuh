// SPDX-License-Identifier: MIT
//
// The inputs that all stages of both pipelines share.
#pragma once

#include <algorithm>
#include <functional>
#include <stop_token>

#include "raster/api/renderer.h"
#include "raster/cuda/common/footprints.cuh"
#include "raster/cuda/common/upload.cuh"

namespace qs::cuda {

struct FrameContext {
  const DeviceCloud& cloud;
  const Camera& camera;
  const RenderSettings& settings;
  TileGrid grid;
  cudaStream_t stream;
  std::stop_token stop;
  /// Enqueues the work behind the frame: presenting its pixels, counting the pairs of all modes.
  /// Pipelines call it right after they have enqueued the frame, and again if the frame has to be
  /// redrawn with larger buffers.
  std::function<void()> enqueue_behind;
  std::size_t number = 0;  ///< of the frame among the frames of a picture: these differ in size

  int sh_degree() const { return std::min(settings.sh_degree, cloud.sh_degree); }
  bool antialiased() const { return settings.antialiased.value_or(cloud.antialiased); }
  FootprintRules rules() const { return footprint_rules(settings, antialiased()); }

  /// Called between stages. Work that was already enqueued still completes.
  void throw_if_cancelled() const {
    if (stop.stop_requested()) throw Cancelled{};
  }
};

}  // namespace qs::cuda
