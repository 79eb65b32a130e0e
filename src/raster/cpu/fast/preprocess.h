// SPDX-License-Identifier: MIT
//
// Stage 1: finds the Gaussians that the view shows, and their tiles. Blocks that the view can show
// pass through project, tile_rects and color; see survivors.h.
#pragma once

#include "raster/cpu/common/visible.h"
#include "raster/cpu/fast/scene.h"
#include "raster/cpu/fast/tile_rects.h"
#include "raster/kernel/blend.h"

namespace qs::cpu::fast {

/// A visible Gaussian as the blend stage reads it: one cache line. At the offset (dx, dy) from the
/// mean, log2 of 256 alpha is log2_256_opacity - along dx^2 - (scale (dy - slope dx))^2: rounding
/// cannot lift it above log2_256_opacity.
struct alignas(64) Record {
  float mean_x, mean_y;
  float log2_256_opacity;
  float along, slope;
  float height;  ///< px: at least 1 / scale
  float scale;   ///< 1 / px
  float red, green, blue;

  float opacity() const { return exp2_polynomial(log2_256_opacity - 8); }
};

struct FastVisible : VisibleSlots {
  Array<std::uint32_t> rows;    ///< per slot: tile rows of the listing, begin + (end << 16)
  Array<Listing> listings;      ///< per slot
  Array<Record> records;        ///< per slot
  std::vector<RectList> rects;  ///< per chunk

  /// Pairs per tile as corner differences of rectangles, (rows + 1) x (columns + 1): summing along
  /// both axes gives the counts. One table per thread.
  std::vector<Array<std::int32_t>> corners;

  /// The first rectangle of a slot that has several.
  const PackedTileRect* rects_of(std::uint32_t slot) const {
    return &rects[slot / kChunk][listings[slot].several.first];
  }
};

/// `scene` was made of frame.cloud. Footprints are filled if `traced`.
void preprocess(const FrameContext& frame, const SceneBlocks& scene, bool traced,
                FastVisible& visible);

}  // namespace qs::cpu::fast
