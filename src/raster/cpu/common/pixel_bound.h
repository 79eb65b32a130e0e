// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>

#include "raster/kernel/constants.h"
#include "raster/kernel/cull/culler.h"

namespace qs::cpu {

/// Conservative bound of the pixels with alpha >= 1/255, used to skip pixels cheaply. It may
/// include other pixels but never excludes such a pixel.
struct PixelBound {
  glm::vec2 half;   ///< half size in pixels of a box around the mean; 0 = no pixel
  float slope;      ///< along a row the falloff is largest at dx = slope * dy
  float threshold;  ///< pixels with a smaller log2 of the falloff have alpha < 1/255

  static PixelBound of(const Footprint& footprint) {
    if (!(footprint.gamma > 0.0f)) return {{0, 0}, 0, 0};
    return {extents(footprint).max + 1.0f, footprint.covariance.xy / footprint.covariance.yy,
            kLog2OfFalloff * footprint.gamma - kLog2Slack};
  }
};

}  // namespace qs::cpu
