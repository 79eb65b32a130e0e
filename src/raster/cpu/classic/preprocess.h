// SPDX-License-Identifier: MIT
//
// Stage 1: finds the Gaussians that the view shows.
#pragma once

#include "raster/cpu/visible.h"
#include "raster/kernel/blend.h"
#include "raster/scene/activated_cloud.h"

namespace qs::cpu {

/// Conservative bound of the pixels with alpha >= 1/255, used to skip pixels cheaply. It may
/// include pixels that do not count but never excludes one that does.
struct PixelBound {
  glm::vec2 half;   ///< half size in pixels of a box around the mean; 0 = no pixel
  float slope;      ///< along a row the falloff is largest at dx = slope * dy
  float threshold;  ///< pixels with a smaller log2 of the falloff have alpha < 1/255

  static PixelBound of(const Footprint& footprint);
};

struct BoundedSplat {
  Splat splat;
  PixelBound bound;
};

struct Visible : VisibleSlots {
  Array<BoundedSplat> splats;  ///< per slot
};

/// Projects, culls by the frame's mode and evaluates colours. A Gaussian without tiles is not
/// visible.
void preprocess(const FrameContext& frame, const ActivatedCloud& active, Visible& visible);

}  // namespace qs::cpu
