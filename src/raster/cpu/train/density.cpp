// SPDX-License-Identifier: MIT
#include "raster/cpu/train/density.h"

#include <cmath>

namespace qs::cpu::train {

void DensityStatistics::reset(std::size_t gaussians) {
  sums.assign(gaussians, 0);
  views.assign(gaussians, 0);
}

void DensityStatistics::add(const Gradients<float>& gradients, int width, int height) {
  const glm::vec2 half(0.5f * static_cast<float>(width), 0.5f * static_cast<float>(height));
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (gradients.visible[i] == 0) continue;
    const glm::vec2 ndc = half * gradients.mean_px[i];
    const float norm = std::sqrt(ndc.x * ndc.x + ndc.y * ndc.y);
    if (norm - norm == 0.0f) sums[i] += norm;  // finite
    ++views[i];
  }
}

float DensityStatistics::mean(std::size_t i) const {
  return views[i] == 0 ? 0 : sums[i] / static_cast<float>(views[i]);
}

}  // namespace qs::cpu::train
