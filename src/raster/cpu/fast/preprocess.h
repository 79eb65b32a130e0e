// SPDX-License-Identifier: MIT
//
// Stage 1: from the scene to the Gaussians that this view shows, with the tiles that the mode gives
// them. Blocks that the view can show pass through project, list and color; see survivors.h.
#pragma once

#include "raster/cpu/fast/list.h"
#include "raster/cpu/fast/scene.h"
#include "raster/cpu/visible.h"
#include "raster/kernel/blend.h"

namespace qs::cpu::fast {

/// What blending reads of a visible Gaussian: one cache line.
struct alignas(64) Record {
  float mean_x, mean_y;
  float a, b, c;  ///< log2 of the falloff is a dx^2 + b dx dy + c dy^2
  float log2_opacity;
  float red, green, blue;
  float x_over_y;        ///< for a given dy the falloff is largest at dx = x_over_y * dy
  float y_over_x;        ///< for a given dx the falloff is largest at dy = y_over_x * dx
  float threshold;       ///< log2 of the falloff below which alpha < 1/255, with room for rounding
  float wide_a, wide_c;  ///< a and c, less steep by more than the rounding of the sum on needles

  Splat splat() const {
    return {{mean_x, mean_y}, {a, b, c}, exp2_polynomial(log2_opacity), {red, green, blue}};
  }
};

struct Visible : VisibleSlots {
  Array<Listing> listings;      ///< per slot
  Array<Record> records;        ///< per slot
  std::vector<RectList> rects;  ///< per chunk

  /// How many Gaussians have each tile, as the corner differences of rectangles over
  /// (rows + 1) x (columns + 1): summing along both axes gives the numbers. One table per thread.
  std::vector<Array<std::int32_t>> corners;

  /// The first of a slot's rectangles.
  const Rect* rects_of(std::uint32_t slot) const {
    return &rects[slot / kChunk][listings[slot].first];
  }
};

/// `scene` is frame.cloud's; footprints are filled when `traced`.
void preprocess(const FrameContext& frame, const Scene& scene, bool traced, Visible& visible);

}  // namespace qs::cpu::fast
