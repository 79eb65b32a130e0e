// SPDX-License-Identifier: MIT
//
// The statistics of adaptive density control, as both backends sum it: the length of the loss's
// gradient by a Gaussian's position on the image.
#pragma once

#include <cmath>

#include <glm/vec2.hpp>

#include "raster/kernel/hd.h"

namespace qs {

/// Adds |dL/d mean| of a view, or its absolute sums, see BackwardOrder, in normalised device
/// coordinates, where the image is 2 wide and 2 high. `half_px` is half the image's size in pixels;
/// `sum` is the Gaussian's sum over the views before. A gradient that is not finite adds nothing.
QS_HD void add_movement(const glm::vec2& half_px, const glm::vec2& d_mean_px, float& sum) {
  const glm::vec2 ndc = half_px * d_mean_px;
  const float norm = std::sqrt(ndc.x * ndc.x + ndc.y * ndc.y);
  if (norm - norm == 0.0f) sum += norm;
}

}  // namespace qs
