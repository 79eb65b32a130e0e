// SPDX-License-Identifier: MIT
#include "raster/cpu/blend.h"

#include <algorithm>
#include <cmath>

namespace qs::cpu {
namespace {

/// One row of a tile while it is composited; lanes are pixels. Plain arrays of a fixed length, so
/// that compilers turn the loops over lanes into vector code.
struct Row {
  float transmittance[kTileSize];
  float r[kTileSize], g[kTileSize], b[kTileSize];
  std::int32_t live[kTileSize];       ///< 1 until the pixel stops, then 0
  std::int32_t evaluated[kTileSize];  ///< list entries up to and including the one it stopped at
  bool any_live;
};

/// Composites one Gaussian onto a row whose first pixel is `dx`, `dy` away from its mean.
/// `entry` is its 1-based place in the list. True when a pixel stopped here.
bool blend_row(const Splat& splat, float dx, float dy, std::int32_t entry, Row& row) {
  std::int32_t stops = 0;
  for (int lane = 0; lane < kTileSize; ++lane) {
    const float power = log2_falloff(splat, dx + static_cast<float>(lane), dy);
    const float alpha = alpha_of(splat, power);
    const float next = row.transmittance[lane] * (1.0f - alpha);
    const std::int32_t counts =
        row.live[lane] & std::int32_t(power <= 0.0f) & std::int32_t(alpha >= kAlphaMin);
    const std::int32_t stop = counts & std::int32_t(next < kTransmittanceMin);
    const std::int32_t use = counts & ~stop;
    const float weight = use != 0 ? alpha * row.transmittance[lane] : 0.0f;
    row.r[lane] += weight * splat.color.x;
    row.g[lane] += weight * splat.color.y;
    row.b[lane] += weight * splat.color.z;
    row.transmittance[lane] = use != 0 ? next : row.transmittance[lane];
    row.live[lane] &= ~stop;
    row.evaluated[lane] = stop != 0 ? entry : row.evaluated[lane];
    stops |= stop;
  }
  return stops != 0;
}

/// Rows [begin, end) of a tile that a Gaussian can reach with alpha >= 1/255. A pixel of slack on
/// top of the ellipse's extent makes sure that rounding decides nothing here.
Span reached_rows(const Footprint& footprint, float tile_top, int rows) {
  if (!(footprint.gamma > 0.0f)) return {0, 0};
  const float half = extents(footprint).max.y + 1.0f;
  const float top = footprint.mean_px.y - tile_top;
  return {clamp_to_int(top - half, rows), clamp_to_int(top + half + 1.0f, rows)};
}

void blend_tile(const FrameContext& frame, const Visible& visible, const TileLists& lists,
                std::size_t tile, const Outputs& outputs, Frame& result) {
  const int x0 = static_cast<int>(tile) % frame.grid.columns * kTileSize;
  const int y0 = static_cast<int>(tile) / frame.grid.columns * kTileSize;
  const int width = std::min(kTileSize, frame.camera.width - x0);
  const int height = std::min(kTileSize, frame.camera.height - y0);
  const std::uint32_t length = lists.pairs(tile);
  const std::uint32_t* list = lists.slots.data() + lists.begin[tile];

  Row rows[kTileSize] = {};
  for (Row& row : rows) {
    std::fill_n(row.transmittance, kTileSize, 1.0f);
    std::fill_n(row.live, width, 1);  // lanes outside the image never count
    std::fill_n(row.evaluated, kTileSize, static_cast<std::int32_t>(length));
    row.any_live = true;
  }
  int live_rows = height;
  for (std::uint32_t entry = 0; entry < length && live_rows > 0; ++entry) {
    const std::uint32_t slot = list[entry];
    const Splat& splat = visible.splats[slot];
    const Span reached = reached_rows(visible.footprints[slot], static_cast<float>(y0), height);
    for (int y = reached.begin; y < reached.end; ++y) {
      Row& row = rows[y];
      if (!row.any_live) continue;
      const float dx = static_cast<float>(x0) - splat.mean_px.x;
      const float dy = static_cast<float>(y0 + y) - splat.mean_px.y;
      if (blend_row(splat, dx, dy, static_cast<std::int32_t>(entry + 1), row)) {
        row.any_live =
            std::any_of(row.live, row.live + width, [](std::int32_t live) { return live != 0; });
        if (!row.any_live) --live_rows;
      }
    }
  }

  const glm::vec3 background = frame.settings.background;
  for (int y = 0; y < height; ++y) {
    const Row& row = rows[y];
    for (int x = 0; x < width; ++x) {
      if (outputs.color) {
        float* pixel = result.color.row(y0 + y) + (x0 + x) * 3;
        pixel[0] = row.r[x] + row.transmittance[x] * background.x;
        pixel[1] = row.g[x] + row.transmittance[x] * background.y;
        pixel[2] = row.b[x] + row.transmittance[x] * background.z;
      }
      if (outputs.evaluated) {
        const auto at =
            static_cast<std::size_t>(y0 + y) * static_cast<std::size_t>(frame.camera.width) +
            static_cast<std::size_t>(x0 + x);
        result.evaluated[at] = static_cast<std::uint32_t>(row.evaluated[x]);
      }
    }
  }
}

}  // namespace

void blend(const FrameContext& frame, const Visible& visible, const TileLists& lists,
           const Outputs& outputs, Frame& result) {
  frame.for_chunks(static_cast<std::size_t>(frame.grid.count()), 4,
                   [&](std::size_t begin, std::size_t end, int) {
                     for (std::size_t tile = begin; tile < end; ++tile)
                       blend_tile(frame, visible, lists, tile, outputs, result);
                   });
}

}  // namespace qs::cpu
