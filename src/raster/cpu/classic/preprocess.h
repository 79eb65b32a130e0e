// SPDX-License-Identifier: MIT
//
// Stage 1: from the scene to the Gaussians that this view shows.
#pragma once

#include "raster/cpu/visible.h"
#include "raster/kernel/blend.h"

namespace qs::cpu {

/// Where a Gaussian can have alpha >= 1/255, so that blending skips pixels for nothing. It only
/// ever errs towards touching: rounding decides nothing here.
struct Reach {
  glm::vec2 half;   ///< pixels around the mean, with a pixel to spare; 0 = nowhere
  float slope;      ///< along a row the falloff is largest at dx = slope * dy
  float threshold;  ///< log2 of the falloff below which alpha < 1/255, with room for rounding

  static Reach of(const Footprint& footprint);
};

/// What blending reads of a visible Gaussian.
struct BlendRecord {
  Splat splat;
  Reach reach;
};

struct Visible : VisibleSlots {
  Array<BlendRecord> records;  ///< per slot
};

/// Projects, culls by the frame's mode (a Gaussian without a tile is not visible) and colours.
void preprocess(const FrameContext& frame, Visible& visible);

}  // namespace qs::cpu
