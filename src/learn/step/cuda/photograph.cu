// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cassert>

#include "learn/gradient/loss.h"
#include "learn/step/cuda/photograph.cuh"

namespace qs::cuda::train {
namespace {

/// One thread per pixel; `alpha` may be null.
__global__ void __launch_bounds__(kThreads)
    draw_photograph(const std::uint8_t* rgb, const std::uint8_t* alpha, std::uint32_t pixels,
                    glm::vec3 background, glm::vec3* target) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= pixels) return;
  glm::vec3 color = photograph_color(rgb + std::size_t{3} * i);
  if (alpha != nullptr) color += background_behind(alpha[i], background);
  target[i] = color;
}

void copy_bytes(std::span<const std::uint8_t> from, DeviceBuffer<std::uint8_t>& to,
                cudaStream_t stream) {
  to.reserve("a photograph", from.size());
  if (from.empty()) return;
  check(cudaMemcpyAsync(to.data(), from.data(), from.size(), cudaMemcpyHostToDevice, stream),
        "copy to the GPU");
}

}  // namespace

void DevicePhotograph::upload(const qs::train::Photograph& host, cudaStream_t stream) {
  pixels = 0;
  has_alpha = !host.alpha.empty();
  has_mask = !host.mask.empty();
  const std::size_t size = host.rgb.size() / 3;
  assert(!has_alpha || host.alpha.size() == size);
  assert(!has_mask || host.mask.size() == size);
  copy_bytes(host.rgb, rgb, stream);
  copy_bytes(host.alpha, alpha, stream);
  copy_bytes(host.mask, mask, stream);
  check(cudaStreamSynchronize(stream), "copy to the GPU");
  pixels = size;
  counted = size - static_cast<std::size_t>(
                       std::count(host.mask.begin(), host.mask.end(), std::uint8_t{0}));
}

void DevicePhotograph::over(const glm::vec3& background, cudaStream_t stream,
                            DeviceBuffer<glm::vec3>& target) const {
  target.reserve("the step's image", pixels);
  launch("draw_photograph", draw_photograph, blocks_for(pixels), stream, rgb.data(),
         has_alpha ? alpha.data() : nullptr, static_cast<std::uint32_t>(pixels), background,
         target.data());
}

}  // namespace qs::cuda::train
