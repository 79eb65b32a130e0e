// SPDX-License-Identifier: MIT
// Compiled alone: the tests on an emulated GPU replace this file.
#include "learn/lpips/metric.h"

#include <memory>

#include "base/fail.h"
#ifdef QUADSPLAT_HAVE_CUDA
#include "learn/lpips/cuda/gpu_metric.h"
#endif

namespace qs {

LpipsDistance make_lpips(Backend backend, const lpips::Weights& weights, ThreadPool& pool,
                         [[maybe_unused]] int device) {
  if (backend == Backend::cpu) {
    const auto metric = std::make_shared<const lpips::Metric>(weights);
    return [metric, &pool](const Image& a, const Image& b, lpips::InputRange range) {
      return metric->distance(a, b, range, pool);
    };
  }
#ifdef QUADSPLAT_HAVE_CUDA
  const auto metric = std::make_shared<cuda::lpips::GpuMetric>(weights, device);
  return [metric](const Image& a, const Image& b, lpips::InputRange range) {
    return metric->distance(a, b, range);
  };
#else
  fail(ErrorKind::device, "backend cuda: {}", gpu_report().problem);
#endif
}

}  // namespace qs
