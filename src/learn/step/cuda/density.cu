// SPDX-License-Identifier: MIT
#include "learn/gradient/density.h"
#include "learn/step/cuda/density.cuh"
#include "raster/cuda/common/stream.cuh"

namespace qs::cuda::train {
namespace {

/// One thread per Gaussian.
__global__ void __launch_bounds__(kThreads)
    add_movements(glm::vec2 half_px, std::uint32_t count, const glm::vec2* d_mean_px,
                  const glm::vec2* absolute_px, CountedGaussians counted, float* sums,
                  float* absolute, std::uint32_t* views) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= count || !counted.has(i)) return;
  add_movement(half_px, d_mean_px[i], sums[i]);
  if (absolute != nullptr) add_movement(half_px, absolute_px[i], absolute[i]);
  ++views[i];
}

}  // namespace

void DensityStatistics::reset(std::uint32_t gaussians, cudaStream_t stream) {
  count = gaussians;
  sums.reserve("the statistics", with_room(count));
  views.reserve("the statistics", with_room(count));
  has_absolute = false;
  if (count == 0) return;
  set_zero("reset", sums.data(), count, stream);
  set_zero("reset", views.data(), count, stream);
}

void DensityStatistics::upload(const qs::train::DensityStatistics& host, cudaStream_t stream) {
  count = static_cast<std::uint32_t>(host.sums.size());
  copy_to_device(host.sums.data(), sums, count, stream);
  copy_to_device(host.views.data(), views, count, stream);
  has_absolute = !host.absolute.empty();
  copy_to_device(host.absolute.data(), absolute, host.absolute.size(), stream);
}

void DensityStatistics::download(cudaStream_t stream, qs::train::DensityStatistics& to) const {
  copy_to_host(sums.data(), to.sums, count, stream);
  copy_to_host(views.data(), to.views, count, stream);
  copy_to_host(absolute.data(), to.absolute, has_absolute ? count : 0, stream);
}

void DensityStatistics::add(const Gradients& gradients, CountedGaussians counted, int width,
                            int height, cudaStream_t stream) {
  if (count == 0) return;
  if (gradients.has_absolute && !has_absolute) {
    absolute.reserve("the statistics", with_room(count));
    set_zero("density", absolute.data(), count, stream);
    has_absolute = true;
  }
  const glm::vec2 half_px(0.5f * static_cast<float>(width), 0.5f * static_cast<float>(height));
  launch("add_movements", add_movements, blocks_for(count), stream, half_px, count,
         gradients.mean_px.data(), gradients.absolute_px.data(), counted, sums.data(),
         gradients.has_absolute ? absolute.data() : nullptr, views.data());
}

}  // namespace qs::cuda::train
