// SPDX-License-Identifier: MIT
//
// Stage 1: finds the Gaussians that the view shows, and their tiles. Blocks that the view can show
// pass through project, tile_rects and color; see survivors.h.
#pragma once

#include "raster/cpu/fast/scene.h"
#include "raster/cpu/fast/tile_rects.h"
#include "raster/cpu/visible.h"
#include "raster/kernel/blend.h"

namespace qs::cpu::fast {

/// A visible Gaussian as the blend stage reads it: one cache line.
struct alignas(64) Record {
  float mean_x, mean_y;
  float a, b, c;  ///< log2 of the falloff is a dx^2 + b dx dy + c dy^2
  float log2_opacity;
  float red, green, blue;
  float x_over_y;        ///< for a given dy the falloff is largest at dx = x_over_y * dy
  float y_over_x;        ///< for a given dx the falloff is largest at dy = y_over_x * dx
  float threshold;       ///< pixels with a smaller log2 of the falloff have alpha < 1/255
  float wide_a, wide_c;  ///< a and c, less steep by kFalloffRounding

  Splat splat() const {
    return {{mean_x, mean_y}, {a, b, c}, exp2_polynomial(log2_opacity), {red, green, blue}};
  }
};

struct Visible : VisibleSlots {
  Array<Listing> listings;      ///< per slot
  Array<Record> records;        ///< per slot
  std::vector<RectList> rects;  ///< per chunk

  /// Pairs per tile as corner differences of rectangles, (rows + 1) x (columns + 1): summing along
  /// both axes gives the counts. One table per thread.
  std::vector<Array<std::int32_t>> corners;

  /// The first rectangle of a slot.
  const Rect* rects_of(std::uint32_t slot) const {
    return &rects[slot / kChunk][listings[slot].first];
  }
};

/// `scene` was made of frame.cloud. Footprints are filled if `traced`.
void preprocess(const FrameContext& frame, const Scene& scene, bool traced, Visible& visible);

}  // namespace qs::cpu::fast
