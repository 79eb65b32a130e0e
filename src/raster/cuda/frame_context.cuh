// SPDX-License-Identifier: MIT
//
// The inputs that every stage of the CUDA backend shares.
#pragma once

#include <algorithm>
#include <functional>
#include <stop_token>
#include <string>

#include "raster/api/renderer.h"
#include "raster/cuda/upload.cuh"

namespace qs::cuda {

struct FrameContext {
  const DeviceCloud& cloud;
  const Camera& camera;
  const RenderSettings& settings;
  TileGrid grid;
  cudaStream_t stream;
  std::stop_token stop;
  /// Enqueues the work that consumes the finished pixels, for example presenting them. Pipelines
  /// call it right after they have enqueued the frame, and again if the frame has to be redrawn
  /// with larger buffers.
  std::function<void()> enqueue_present;

  int sh_degree() const { return std::min(settings.sh_degree, cloud.sh_degree); }
  bool antialiased() const { return settings.antialiased.value_or(cloud.antialiased); }
  FootprintRules rules() const {
    return {row_of(settings.mode).keeps_faint, antialiased(), settings.splat_scale,
            static_cast<float>(settings.dilation)};
  }

  /// Called between stages. Work that was already enqueued still completes.
  void throw_if_cancelled() const {
    if (stop.stop_requested()) throw Cancelled{};
  }
};

/// Pairs are counted in 64 bits but indexed with 31.
inline constexpr std::uint64_t kMaxPairs = 0x7fffffff;

/// Throws Error(device) if a view lists more tile pairs than can be indexed.
inline void require_indexable(std::uint64_t tile_pairs) {
  if (tile_pairs <= kMaxPairs) return;
  throw Error(ErrorKind::device, "cuda: bin: this view lists " + std::to_string(tile_pairs) +
                                     " tile pairs, at most " + std::to_string(kMaxPairs) +
                                     " can be sorted");
}

}  // namespace qs::cuda
