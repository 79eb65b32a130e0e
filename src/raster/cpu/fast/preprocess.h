// SPDX-License-Identifier: MIT
//
// Stage 1: finds the Gaussians that the view shows, and their tiles. Blocks that the view can show
// pass through project, tile_rects and color; see survivors.h.
#pragma once

#include <cfloat>

#include "raster/cpu/fast/scene.h"
#include "raster/cpu/fast/tile_rects.h"
#include "raster/cpu/visible.h"
#include "raster/kernel/blend.h"

namespace qs::cpu::fast {

/// The ellipse in which alpha >= 1/255, relative to the mean. In the row v pixels below the mean it
/// spans slope v +- (sqrt(half2 - narrowing v^2) + margin), if |v| <= y_max. It is enlarged for
/// rounding, and does not depend on the culling mode, so lossless modes stay equal bit for bit.
struct AlphaEllipse {
  float y_max;      ///< < 0: the ellipse is empty
  float slope;      ///< of the line through the centres of the rows' spans
  float v_extreme;  ///< row of the rightmost point; -v_extreme is the row of the leftmost point
  float half2, narrowing;
  float margin;  ///< px
};

inline constexpr float kNoLimit = FLT_MAX;

/// A visible Gaussian as the blend stage reads it: one cache line.
struct alignas(64) Record {
  float mean_x, mean_y;
  float a, b, c;  ///< log2 of the falloff is a dx^2 + b dx dy + c dy^2
  float log2_opacity;
  float red, green, blue;
  /// log2 alpha is limited to this; kNoLimit if rounding cannot lift it above log2 of kAlphaMax.
  float limit;
  AlphaEllipse ellipse;

  Splat splat() const {
    return {{mean_x, mean_y}, {a, b, c}, exp2_polynomial(log2_opacity), {red, green, blue}};
  }
};

struct FastVisible : VisibleSlots {
  Array<Listing> listings;      ///< per slot
  Array<Record> records;        ///< per slot
  std::vector<RectList> rects;  ///< per chunk

  /// Pairs per tile as corner differences of rectangles, (rows + 1) x (columns + 1): summing along
  /// both axes gives the counts. One table per thread.
  std::vector<Array<std::int32_t>> corners;

  /// The first rectangle of a slot.
  const PackedTileRect* rects_of(std::uint32_t slot) const {
    return &rects[slot / kChunk][listings[slot].first];
  }
};

/// `scene` was made of frame.cloud. Footprints are filled if `traced`.
void preprocess(const FrameContext& frame, const SceneBlocks& scene, bool traced,
                FastVisible& visible);

}  // namespace qs::cpu::fast
