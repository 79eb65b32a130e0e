// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/preprocess.h"

#include <algorithm>
#include <cmath>

#include "raster/cpu/fast/color.h"
#include "raster/cpu/fast/project.h"

namespace qs::cpu::fast {
namespace {

AlphaEllipse ellipse_of(const Survivors& s, std::size_t k) {
  if (!(s.gamma[k] > 0.0f)) return {-1, 0, 0, 0, 0, 0};
  constexpr float kWider = 1.0005f, kMarginPx = 0.01f, kRounding = 4e-6f;
  const float x_max = std::sqrt(s.gamma[k] * s.xx[k]) * kWider + kMarginPx;
  const float y_max = std::sqrt(s.gamma[k] * s.yy[k]) * kWider + kMarginPx;
  const float half2 = s.gamma[k] / s.conic_a[k] * (kWider * kWider);
  return {y_max, s.xy[k] / s.yy[k],       s.xy[k] / s.xx[k] * x_max,
          half2, half2 / (y_max * y_max), kMarginPx + kRounding * x_max};
}

/// Record::limit.
float limit_of(const Survivors& s, std::size_t k) {
  constexpr float kLog2AlphaMax = -0.014499570f;
  constexpr float kRounding = 2e-5f;              // of log2 alpha, per thinness
  constexpr float kTolerance = 0.005f;            // of log2 alpha
  const float thinness = s.conic_a[k] * s.xx[k];  // >= 1
  const float rounding = std::max(kRounding * thinness, kTolerance);
  const bool stays_below = s.log2_opacity[k] + rounding < kLog2AlphaMax;
  return stays_below ? kNoLimit : std::min(s.log2_opacity[k], kLog2AlphaMax);
}

Record record_of(const Survivors& s, std::size_t k, const Colors& colors) {
  Record record;
  record.mean_x = s.mean_x[k];
  record.mean_y = s.mean_y[k];
  record.a = kLog2OfFalloff * s.conic_a[k];
  record.b = 2 * kLog2OfFalloff * s.conic_b[k];
  record.c = kLog2OfFalloff * s.conic_c[k];
  record.log2_opacity = s.log2_opacity[k];
  record.red = colors.red[s.lane[k]];
  record.green = colors.green[s.lane[k]];
  record.blue = colors.blue[s.lane[k]];
  record.limit = limit_of(s, k);
  record.ellipse = ellipse_of(s, k);
  return record;
}

/// Adds rects[begin...] to a table of corner differences.
void count_tiles_of(const RectList& rects, std::size_t begin, TileGrid grid,
                    Array<std::int32_t>& corners) {
  const auto stride = static_cast<std::size_t>(grid.columns) + 1;
  for (std::size_t i = begin; i < rects.size(); ++i) {
    const PackedTileRect& rect = rects[i];
    ++corners[rect.row_begin * stride + rect.column_begin];
    --corners[rect.row_begin * stride + rect.column_end];
    --corners[rect.row_end * stride + rect.column_begin];
    ++corners[rect.row_end * stride + rect.column_end];
  }
}

}  // namespace

void preprocess(const FrameContext& frame, const SceneBlocks& scene, bool traced,
                FastVisible& visible) {
  visible.resize(frame.cloud.size());
  visible.listings.resize(visible.slots());
  visible.records.resize(visible.slots());
  visible.footprints.resize(traced ? visible.slots() : 0);
  visible.rects.resize(visible.chunk_counts.size());
  visible.corners.resize(static_cast<std::size_t>(frame.pool.size()));
  for (Array<std::int32_t>& corners : visible.corners) {
    corners.assign(static_cast<std::size_t>((frame.grid.rows + 1) * (frame.grid.columns + 1)), 0);
  }

  const View<float> view = make_view<float>(frame.camera);
  const FootprintRules rules = frame.rules();
  const Frustum frustum(view, rules, frame.grid);

  frame.for_chunks(
      visible.slots(), FastVisible::kChunk, [&](std::size_t begin, std::size_t end, int worker) {
        const std::size_t chunk = begin / FastVisible::kChunk;
        // Moved out while it grows, to avoid false sharing: neighbouring lists share a cache line.
        RectList rects = std::move(visible.rects[chunk]);
        rects.clear();
        Survivors survivors;
        Colors colors;
        std::size_t slot = begin;
        for (std::size_t b = begin / kBlock; b < std::min(end / kBlock, scene.blocks.size()); ++b) {
          if (frustum.misses(scene.bounds[b])) continue;
          const Block& block = scene.blocks[b];
          const std::size_t counted = rects.size();
          project(view, rules, frame.grid, block, survivors);
          list_tiles(frame.settings.mode, frame.grid, survivors, rects, &visible.listings[slot]);
          color({scene.harmonics, frame.sh_degree(), view.position}, block, b, survivors, colors);
          count_tiles_of(rects, counted, frame.grid,
                         visible.corners[static_cast<std::size_t>(worker)]);
          for (std::size_t k = 0; k < survivors.count; ++k, ++slot) {
            visible.gaussians[slot] = block.gaussian[survivors.lane[k]];
            visible.depths[slot] = survivors.depth[k];
            visible.records[slot] = record_of(survivors, k, colors);
            if (traced) visible.footprints[slot] = survivors.footprint(k);
          }
        }
        visible.rects[chunk] = std::move(rects);
        visible.chunk_counts[chunk] = static_cast<std::uint32_t>(slot - begin);
      });
  visible.count_all();
}

}  // namespace qs::cpu::fast
