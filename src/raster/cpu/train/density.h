// SPDX-License-Identifier: MIT
//
// What adaptive density control decides by: how much the loss wants to move a Gaussian on the
// image, as the mean over the views that showed it.
#pragma once

#include <cstdint>
#include <vector>

#include "raster/cpu/train/parameters.h"

namespace qs::cpu::train {

struct DensityStatistics {
  /// Per Gaussian: sum of |dL/d mean| in normalised device coordinates, where the image is 2 wide
  /// and 2 high, and the number of views in it.
  std::vector<float> sums;
  std::vector<std::uint32_t> views;

  void reset(std::size_t gaussians);
  void add(const Gradients<float>& gradients, int width, int height);
  /// 0 for a Gaussian that no view showed.
  float mean(std::size_t i) const;
};

}  // namespace qs::cpu::train
