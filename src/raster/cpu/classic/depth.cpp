// SPDX-License-Identifier: MIT
#include "raster/cpu/classic/depth.h"

#include <algorithm>
#include <memory>

#include "raster/kernel/depth.h"

namespace qs::cpu {
namespace {

/// Pixels side by side that are composited together. Compilers vectorise loops of this length.
constexpr int kDepthLanes = 8;
constexpr int kMostPx = kTileSizes.back();

/// The PixelDepth of these pixels, an array per value.
struct DepthStrip {
  float transmittance[kDepthLanes], weights[kDepthLanes], weighted_depths[kDepthLanes],
      median[kDepthLanes];
  std::int32_t live[kDepthLanes];  ///< 1 until the pixel stops, then 0; 0 outside of the image
  int live_count;

  PixelDepth<float> pixel(int lane) const {
    return {transmittance[lane], weights[lane], weighted_depths[lane], median[lane]};
  }

  /// Composites a Gaussian as kernel/composite.h and PixelDepth::add() do. (x, y) is the first
  /// pixel. Returns the number of pixels that stopped.
  int composite(const Splat& splat, float depth, int x, float dy) {
    std::int32_t stops = 0;
    for (int lane = 0; lane < kDepthLanes; ++lane) {
      const float dx = static_cast<float>(x + lane) - splat.mean_px.x;
      const float power = log2_falloff(splat, dx, dy);
      const float alpha = alpha_of(splat, power);
      const float before = transmittance[lane], next = before * (1.0f - alpha);
      const std::int32_t counts =
          live[lane] & std::int32_t(power <= 0.0f) & std::int32_t(alpha >= kAlphaMin);
      const std::int32_t stop = counts & std::int32_t(next < kTransmittanceMin);
      const std::int32_t use = counts & ~stop;
      const float weight = use != 0 ? alpha * before : 0.0f;
      const std::int32_t halves = use & std::int32_t(before > 0.5f) & std::int32_t(next <= 0.5f);
      weights[lane] += weight;
      weighted_depths[lane] += weight * depth;
      median[lane] += halves != 0 ? depth : 0.0f;  // at most once
      transmittance[lane] = use != 0 ? next : before;
      live[lane] &= ~stop;
      stops += stop;
    }
    return stops;
  }
};

/// The pixels of a tile. Coordinates start at its corner.
struct Tile {
  int x0, y0, width, height, live;  ///< live: pixels that have not stopped
  DepthStrip strips[kMostPx][kMostPx / kDepthLanes];

  void begin(const FrameContext& frame, std::size_t tile) {
    const int tile_px = frame.grid.tile_px;
    x0 = static_cast<int>(tile) % frame.grid.columns * tile_px;
    y0 = static_cast<int>(tile) / frame.grid.columns * tile_px;
    width = std::min(tile_px, frame.camera.width - x0);
    height = std::min(tile_px, frame.camera.height - y0);
    live = width * height;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < tile_px; ++x) {
        DepthStrip& strip = strips[y][x / kDepthLanes];
        const int lane = x % kDepthLanes;
        strip.transmittance[lane] = 1;
        strip.weights[lane] = strip.weighted_depths[lane] = strip.median[lane] = 0;
        strip.live[lane] = x < width;
        strip.live_count = lane == 0 ? strip.live[0] : strip.live_count + strip.live[lane];
      }
    }
  }

  void composite(const BoundedSplat& bounded, float depth) {
    const glm::vec2 half = bounded.bound.half;
    const glm::vec2 mean = bounded.splat.mean_px - glm::vec2(x0, y0);
    const Span columns{clamp_to_int(mean.x - half.x, width),
                       clamp_to_int(mean.x + half.x + 1, width)};
    const Span rows{clamp_to_int(mean.y - half.y, height),
                    clamp_to_int(mean.y + half.y + 1, height)};
    if (columns.begin >= columns.end) return;
    for (int y = rows.begin; y < rows.end; ++y) {
      const float dy = static_cast<float>(y0 + y) - bounded.splat.mean_px.y;
      for (int s = columns.begin / kDepthLanes; s <= (columns.end - 1) / kDepthLanes; ++s)
        blend(strips[y][s], bounded, depth, x0 + s * kDepthLanes, dy);
    }
  }

  void blend(DepthStrip& strip, const BoundedSplat& bounded, float depth, int x, float dy) {
    const float dx = static_cast<float>(x) - bounded.splat.mean_px.x;
    if (strip.live_count == 0 || !touches(bounded, dx, dy, kDepthLanes)) return;
    const int stops = strip.composite(bounded.splat, depth, x, dy);
    strip.live_count -= stops;
    live -= stops;
  }
};

}  // namespace

void draw_depth(const FrameContext& frame, const Visible& visible, const TileLists& lists,
                Frame& result) {
  const auto draw_tile = [&](std::size_t index, Tile& tile) {
    tile.begin(frame, index);
    for (std::uint64_t k = lists.begin[index]; k < lists.begin[index + 1] && tile.live > 0; ++k)
      tile.composite(visible.splats[lists.slots[k]], visible.depths[lists.slots[k]]);
    for (int y = 0; y < tile.height; ++y) {
      for (int x = 0; x < tile.width; ++x) {
        const PixelDepth<float> pixel = tile.strips[y][x / kDepthLanes].pixel(x % kDepthLanes);
        const std::size_t at = frame.pixel(tile.x0 + x, tile.y0 + y);
        result.depth.alpha[at] = pixel.alpha();
        result.depth.expected[at] = pixel.expected();
        result.depth.median[at] = pixel.median;
      }
    }
  };
  frame.for_chunks(static_cast<std::size_t>(frame.grid.count()), 4,
                   [&](std::size_t begin, std::size_t end, int) {
                     const auto tile = std::make_unique<Tile>();
                     for (std::size_t i = begin; i < end; ++i) draw_tile(i, *tile);
                   });
}

}  // namespace qs::cpu
