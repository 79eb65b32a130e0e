// SPDX-License-Identifier: MIT
//
// The statistics of adaptive density control on the GPU.
#pragma once

#include <cstdint>

#include "raster/cuda/train/parameters.cuh"

namespace qs::cuda::train {

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
  /// `in_view` is 1 for the Gaussians in the view.
  void add(const Gradients& gradients, const std::uint8_t* in_view, int width, int height,
           cudaStream_t stream);
};

}  // namespace qs::cuda::train
