// SPDX-License-Identifier: MIT
//
// Counts the pixels of a view that blend each Gaussian, and the pixels among them with a large
// error. It walks the lists of the forward pass a second time. The counts are integers, so the
// order of atomic additions does not matter.
#pragma once

#include <cstdint>

#include "learn/step/cuda/forward.cuh"
#include "learn/step/cuda/loss.cuh"

namespace qs::cuda::train {

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
