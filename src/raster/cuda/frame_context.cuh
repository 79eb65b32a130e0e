// SPDX-License-Identifier: MIT
//
// What every stage of the CUDA backend is given.
#pragma once

#include <algorithm>
#include <functional>
#include <stop_token>

#include "raster/cuda/upload.cuh"
#include "raster/renderer.h"

namespace qs::cuda {

struct FrameContext {
  const DeviceCloud& cloud;
  const Camera& camera;
  const RenderSettings& settings;
  TileGrid grid;
  cudaStream_t stream;
  std::stop_token stop;
  /// Puts into the stream what is done with the pixels. Pipelines call it behind the frame without
  /// waiting, and once more when the frame had to be drawn again.
  std::function<void()> sequel;

  int sh_degree() const { return std::min(settings.sh_degree, cloud.sh_degree); }
  bool antialiased() const { return settings.antialiased.value_or(cloud.antialiased); }

  /// Called between stages: what was launched ends by itself.
  void throw_if_cancelled() const {
    if (stop.stop_requested()) throw Cancelled{};
  }
};

}  // namespace qs::cuda
