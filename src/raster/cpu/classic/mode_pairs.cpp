// SPDX-License-Identifier: MIT
// Compiled alone: clang optimises the sanitized walks of all modes for minutes in a larger unit.
#include "raster/cpu/classic/classic.h"

namespace qs::cpu {
namespace {

void add_tiles(const TilesOfModes& own, ModeCounts& counts) {
  for (int i = 0; i < kCullerCount; ++i) {
    counts.tile_pairs[i] += own.tiles[i];
    counts.visible[i] += own.tiles[i] > 0 ? 1 : 0;
  }
}

template <int kTilePx>
void count_with_tiles(const FrameContext& frame, const ActivatedCloud& active, ModeSums& sums) {
  const View<float> view = make_view<float>(frame.camera);
  FootprintRules rules = frame.rules();
  rules.keep_faint = true;
  frame.for_chunks(frame.cloud.size(), VisibleSlots::kChunk,
                   [&](std::size_t begin, std::size_t end, int worker) {
                     ModeCounts counts{};
                     for (std::size_t i = begin; i < end; ++i) {
                       Projected projected;
                       if (!frame.draws(i) || !project(view, rules, active.gaussians[i], projected))
                         continue;
                       add_tiles(tiles_of_modes<kTilePx>(projected.footprint, frame.grid), counts);
                     }
                     sums.add(worker, counts);
                   });
}

}  // namespace

void Classic::count_modes(const FrameContext& counted, ModeSums& sums) const {
  with_tile_px(counted.grid.tile_px,
               [&](auto px) { count_with_tiles<px()>(counted, active_, sums); });
}

}  // namespace qs::cpu
