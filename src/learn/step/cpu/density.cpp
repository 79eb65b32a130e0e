// SPDX-License-Identifier: MIT
#include "learn/step/cpu/density.h"

#include "learn/gradient/density.h"

namespace qs::cpu::train {

void add_view(const Gradients<float>& gradients, std::span<const std::uint8_t> counted, int width,
              int height, DensityStatistics& statistics) {
  const glm::vec2 half(0.5f * static_cast<float>(width), 0.5f * static_cast<float>(height));
  const bool absolute = !gradients.absolute_px.empty();
  if (absolute) statistics.absolute.resize(statistics.sums.size());
  for (std::size_t i = 0; i < statistics.sums.size(); ++i) {
    if (counted[i] == 0) continue;
    add_movement(half, gradients.mean_px[i], statistics.sums[i]);
    if (absolute) add_movement(half, gradients.absolute_px[i], statistics.absolute[i]);
    ++statistics.views[i];
  }
}

}  // namespace qs::cpu::train
