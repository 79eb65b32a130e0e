// SPDX-License-Identifier: MIT
//
// The statistics on the GPU from which plans change the number of Gaussians: movements, for
// adaptive density control, and the pixels of a view that blend each Gaussian, with the pixels
// among them that have a large error. These are counted by a second walk through the lists of the
// forward pass. The counts are integers, so the order of atomic additions does not matter.
#pragma once

#include <cstdint>

#include "learn/step/cuda/forward.cuh"
#include "learn/step/cuda/loss.cuh"

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

/// The host's PixelCounts.
struct PixelCounts {
  DeviceBuffer<std::uint32_t> blended, flagged;
  std::uint32_t count = 0;  ///< Gaussians; 0: nothing was counted

  void download(cudaStream_t stream, qs::train::PixelCounts& to) const;
};

/// Memory of count_errors() that the next view uses again.
struct ErrorScratch {
  DeviceBuffer<std::uint16_t> bins;       ///< per pixel: error_bin()
  DeviceBuffer<std::uint32_t> histogram;  ///< histogram of the bins
  DeviceBuffer<std::uint16_t> limit;      ///< error_limit(), one value
};

/// Adds the view's pixels to `counts`, which first becomes zero for `gaussians` Gaussians if
/// nothing was counted. `frame` is the result of forward(). Does not wait. Throws Error(device) if
/// memory is short, before it adds anything.
void count_errors(const StepView& view, const ForwardFrame& frame, const Comparison& pictures,
                  std::uint32_t gaussians, ErrorScratch& scratch, PixelCounts& counts);

}  // namespace qs::cuda::train
