// SPDX-License-Identifier: MIT
//
// LPIPS on the GPU, with the sums of the CPU in the same order.
#pragma once

#include <memory>

#include "learn/lpips/lpips.h"

namespace qs::cuda::lpips {

class GpuMetric {
 public:
  /// `device` is an index into GpuReport::gpus. Throws Error(device).
  GpuMetric(const qs::lpips::Weights& weights, int device);
  ~GpuMetric();

  /// As Metric::distance(). Both pictures pass through the network as a whole, so memory grows with
  /// their pixels: 1 GiB for a megapixel with VGG16. Throws Error(device).
  double distance(const Image& a, const Image& b, qs::lpips::InputRange range);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace qs::cuda::lpips
