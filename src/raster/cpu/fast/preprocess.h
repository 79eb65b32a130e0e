// SPDX-License-Identifier: MIT
//
// Stage 1: finds the Gaussians that the view shows, and their tiles. Blocks that the view can show
// pass through project, tile_rects, color and records; see survivors.h.
#pragma once

#include "raster/cpu/fast/records.h"
#include "raster/cpu/fast/scene.h"
#include "raster/cpu/fast/tile_rects.h"
#include "raster/cpu/visible.h"

namespace qs::cpu::fast {

struct FastVisible : VisibleSlots {
  Array<std::uint32_t> rows;    ///< per slot: tile rows of the listing, begin + (end << 16)
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
