// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/pipeline.h"

#include <algorithm>
#include <cmath>

#include "raster/cpu/common/frame_context.h"

namespace qs::cpu::fast {
namespace {

Record record_of(const Survivors& s, std::size_t k, const Colors& colors) {
  constexpr float kWider = 1.0005f;  // more than the error of a root in tile.cpp
  Record record;
  record.mean_x = s.mean_x[k];
  record.mean_y = s.mean_y[k];
  record.log2_256_opacity = s.log2_opacity[k] + 8;
  record.along = -kLog2OfFalloff / s.xx[k];
  record.slope = s.xy[k] / s.xx[k];
  record.scale = std::sqrt(-kLog2OfFalloff * s.conic_c[k]);
  record.height = kWider / record.scale;
  record.red = colors.red[s.lane[k]];
  record.green = colors.green[s.lane[k]];
  record.blue = colors.blue[s.lane[k]];
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

// Of the tiles whose lists are used.
Frustum frustum_of(const FrameContext& frame, const View<float>& view,
                   const FootprintRules& rules) {
  if (!frame.only) return {view, rules, frame.grid};
  const PixelBox& box = *frame.only;
  const auto tiles = [](int x, int y) {
    return double{kTileSize} * glm::dvec2(x / kTileSize, y / kTileSize);
  };
  return {view, rules, tiles(box.x0, box.y0),
          tiles(box.x1 + kTileSize - 1, box.y1 + kTileSize - 1)};
}

}  // namespace

void preprocess(const FrameContext& frame, const SceneBlocks& scene, bool traced,
                FastVisible& visible) {
  visible.resize(frame.cloud.size());
  visible.rows.resize(visible.slots());
  visible.listings.resize(visible.slots());
  visible.records.resize(visible.slots());
  visible.footprints.resize(traced ? visible.slots() : 0);
  visible.rects.resize(visible.chunk_counts.size());
  visible.corners.resize(static_cast<std::size_t>(frame.pool.size()));
  for (Array<std::int32_t>& corners : visible.corners)
    corners.assign(static_cast<std::size_t>((frame.grid.rows + 1) * (frame.grid.columns + 1)), 0);

  const View<float> view = make_view<float>(frame.camera);
  const FootprintRules rules = frame.rules();
  const Frustum frustum = frustum_of(frame, view, rules);

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
          if (!scene.shows(frustum, b)) continue;
          const Block& block = scene.blocks[b];
          const std::size_t counted = rects.size();
          project(view, rules, frame.grid, block, scene.drawn_in(b), survivors);
          list_tiles(frame.settings.mode, frame.grid, survivors, rects, &visible.listings[slot],
                     &visible.rows[slot]);
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

void FastPipeline::list(const FrameContext& frame, bool traced, RenderStats& stats) {
  timed(Stage::preprocess, stats, [&] { preprocess(frame, scene_, traced, visible_); });
  timed(Stage::sort, stats, [&] { sort(frame, visible_, bands_); });
  timed(Stage::bin, stats, [&] { bin(frame, visible_, bands_, lists_); });
}

void FastPipeline::draw(const FrameContext& frame, const Outputs& outputs, Frame& result) {
  RenderStats& stats = result.stats;
  list(frame, outputs.trace, stats);
  if (outputs.color || outputs.evaluated)
    timed(Stage::blend, stats, [&] { blend(frame, visible_, lists_, queue_, outputs, result); });
  const auto splat_of = [&](std::uint32_t slot) {
    const Record& record = visible_.records[slot];
    return make_splat(visible_.footprints[slot], record.opacity(),
                      {record.red, record.green, record.blue});
  };
  collect(frame, visible_, lists_, splat_of, outputs, result);
}

// The picture with other colours: color_of(slot).
template <class ColorOf>
Image FastPipeline::painted(const FrameContext& view, bool depths, const ColorOf& color_of) {
  view.pool.for_each(visible_.chunk_counts.size(), 1, [&](std::size_t chunk) {
    const std::size_t first = chunk * FastVisible::kChunk;
    for (std::size_t slot = first; slot < first + visible_.chunk_counts[chunk]; ++slot) {
      const glm::vec3 color = color_of(slot);
      Record& record = visible_.records[slot];
      record.red = color.x, record.green = color.y, record.blue = color.z;
    }
  });
  Frame frame;
  frame.color = Image(view.camera.width, view.camera.height, 3);
  blend(view, visible_, lists_, queue_, {}, frame, depths);
  return std::move(frame.color);
}

void FastPipeline::pass_again(const FrameContext& frame, bool is_drawn, const Outputs& outputs,
                              Frame& result) {
  RenderSettings settings = frame.settings;
  settings.background = glm::vec3(0);
  FrameContext view{frame.cloud, frame.camera,
                    settings,    TileGrid::of_image(frame.camera.width, frame.camera.height),
                    frame.pool,  frame.stop,
                    {},          frame.drawn,
                    {}};
  if (outputs.seen && !outputs.share && !outputs.depth) view.only = outputs.seen->box;
  RenderStats unused;
  if (!is_drawn) list(view, false, unused);
  if (outputs.seen) mark_seen(view, visible_, lists_, *outputs.seen, result.seen);
  if (outputs.depth) {
    const Image sums = painted(
        view, true, [&](std::size_t slot) { return glm::vec3(visible_.depths[slot], 1, 0); });
    for (std::size_t i = 0; i < result.depth.alpha.size(); ++i) {
      const float* const sum = &sums.values[3 * i];
      result.depth.alpha[i] = sum[1];
      result.depth.expected[i] = sum[1] > 0 ? sum[0] / sum[1] : 0;
      result.depth.median[i] = sum[2];
    }
  }
  if (!outputs.share) return;
  // The Gaussians of the set are white and all others black.
  const Image shares = painted(view, false, [&](std::size_t slot) {
    return glm::vec3((*outputs.share)[visible_.gaussians[slot]] ? 1 : 0, 0, 0);
  });
  for (std::size_t i = 0; i < result.share.size(); ++i) result.share[i] = shares.values[3 * i];
}

}  // namespace qs::cpu::fast
