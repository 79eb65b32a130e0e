// SPDX-License-Identifier: MIT
//
// The statistics of adaptive density control on the GPU.
#pragma once

#include <cstdint>

#include "learn/step/cuda/parameters.cuh"

namespace qs::cuda::train {

/// The Gaussians for which a view counts.
struct CountedGaussians {
  const std::uint8_t* in_view;       ///< 1 for the Gaussians in the view
  const std::uint32_t* tile_counts;  ///< null, or above 0 for the Gaussians that count instead

  __device__ bool has(std::uint32_t i) const {
    return tile_counts != nullptr ? tile_counts[i] > 0 : in_view[i] != 0;
  }
};

struct DensityStatistics {
  /// Per Gaussian: sum of |dL/d mean|, see add_movement(), and the number of views in it.
  DeviceBuffer<float> sums;
  DeviceBuffer<std::uint32_t> views;
  DeviceBuffer<float> absolute;  ///< the same as `sums` for absolute gradients, if has_absolute
  bool has_absolute = false;
  std::uint32_t count = 0;

  void reset(std::uint32_t gaussians, cudaStream_t stream);
  void upload(const qs::train::DensityStatistics& host, cudaStream_t stream);
  void download(cudaStream_t stream, qs::train::DensityStatistics& to) const;
  /// Counts the view for the Gaussians of `counted`.
  void add(const Gradients& gradients, CountedGaussians counted, int width, int height,
           cudaStream_t stream);
};

}  // namespace qs::cuda::train
