// SPDX-License-Identifier: MIT
#include "raster/cpu/classic/blend.h"

#include <algorithm>
#include <cmath>

namespace qs::cpu {
namespace {

/// Prefetch distance in list entries. Neighbours in a list are scattered in memory.
constexpr std::uint32_t kPrefetch = 6;

/// Pixels side by side that are composited together. Arrays have this fixed length so that
/// compilers vectorise the loops over lanes.
constexpr int kLanes = 8;
constexpr int kStrips = kTileSize / kLanes;  // in a row of a tile

struct Strip {
  float transmittance[kLanes];
  float r[kLanes], g[kLanes], b[kLanes];
  std::int32_t live[kLanes];  ///< 1 until the pixel stops, then 0; 0 outside of the image
  /// list entries up to and including the entry at which it stopped
  std::int32_t evaluated[kLanes];
  bool any_live;
};

/// Composites one Gaussian onto a strip. (dx, dy) is the strip's first pixel minus the mean,
/// `entry` the Gaussian's 1-based position in the list. True if a pixel stopped.
bool blend_strip(const Splat& splat, float dx, float dy, std::int32_t entry, Strip& strip) {
  std::int32_t stops = 0;
  for (int lane = 0; lane < kLanes; ++lane) {
    const float power = log2_falloff(splat, dx + static_cast<float>(lane), dy);
    const float alpha = alpha_of(splat, power);
    const float next = strip.transmittance[lane] * (1.0f - alpha);
    const std::int32_t counts =
        strip.live[lane] & std::int32_t(power <= 0.0f) & std::int32_t(alpha >= kAlphaMin);
    const std::int32_t stop = counts & std::int32_t(next < kTransmittanceMin);
    const std::int32_t use = counts & ~stop;
    const float weight = use != 0 ? alpha * strip.transmittance[lane] : 0.0f;
    strip.r[lane] += weight * splat.color.x;
    strip.g[lane] += weight * splat.color.y;
    strip.b[lane] += weight * splat.color.z;
    strip.transmittance[lane] = use != 0 ? next : strip.transmittance[lane];
    strip.live[lane] &= ~stop;
    strip.evaluated[lane] = stop != 0 ? entry : strip.evaluated[lane];
    stops |= stop;
  }
  return stops != 0;
}

/// Indices of the cells that mean +- half touches: `count` cells of `size` pixels start at
/// `origin`.
Span reached(float mean, float half, float origin, int size, int count) {
  const float scale = 1.0f / static_cast<float>(size);
  return {clamp_to_int((mean - half - origin) * scale, count),
          clamp_to_int((mean + half - origin) * scale + 1.0f, count)};
}

/// A block of pixels while it is composited: a tile, or a part of a tile larger than kTileSize.
struct BlendBlock {
  Strip strips[kTileSize][kStrips];
  int live_strips = 0;

  BlendBlock(int width, int height, std::uint32_t length) {
    for (int y = 0; y < kTileSize; ++y) {
      for (int x = 0; x < kTileSize; ++x) {
        Strip& strip = strips[y][x / kLanes];
        const int lane = x % kLanes;
        const bool inside = x < width && y < height;
        strip.transmittance[lane] = 1;
        strip.r[lane] = strip.g[lane] = strip.b[lane] = 0;
        strip.live[lane] = inside;
        strip.evaluated[lane] = static_cast<std::int32_t>(length);
        if (lane == 0) {
          strip.any_live = inside;
          live_strips += inside;
        }
      }
    }
  }

  /// Composites one Gaussian. (x0, y0) is the block's first pixel.
  void blend(const BoundedSplat& bounded, float x0, float y0, std::int32_t entry) {
    const Splat& splat = bounded.splat;
    const glm::vec2 half = bounded.bound.half;
    if (!(half.y > 0.0f)) return;
    const Span rows = reached(splat.mean_px.y, half.y, y0, 1, kTileSize);
    const Span columns = reached(splat.mean_px.x, half.x, x0, kLanes, kStrips);
    for (int y = rows.begin; y < rows.end; ++y) {
      const float dy = y0 + static_cast<float>(y) - splat.mean_px.y;
      for (int x = columns.begin; x < columns.end; ++x) {
        Strip& strip = strips[y][x];
        const float dx = x0 + static_cast<float>(x * kLanes) - splat.mean_px.x;
        if (!strip.any_live || !touches(bounded, dx, dy, kLanes)) continue;
        if (blend_strip(splat, dx, dy, entry, strip)) {
          std::int32_t any = 0;
          for (const std::int32_t live : strip.live) any |= live;
          strip.any_live = any != 0;
          live_strips -= !strip.any_live;
        }
      }
    }
  }
};

TileGrid blocks_of(const FrameContext& frame) {
  return TileGrid::of_image(frame.camera.width, frame.camera.height,
                            std::min(frame.grid.tile_px, kTileSize));
}

void blend_block(const FrameContext& frame, const Visible& visible, const TileLists& lists,
                 std::size_t block, const Outputs& outputs, Frame& result) {
  const TileGrid blocks = blocks_of(frame);
  const int x0 = static_cast<int>(block) % blocks.columns * blocks.tile_px;
  const int y0 = static_cast<int>(block) / blocks.columns * blocks.tile_px;
  const int width = std::min(blocks.tile_px, frame.camera.width - x0);
  const int height = std::min(blocks.tile_px, frame.camera.height - y0);
  const auto index = static_cast<std::size_t>(frame.grid.tile_of(x0, y0));
  const std::uint32_t length = lists.pairs(index);
  const std::uint32_t* list = lists.slots.data() + lists.begin[index];

  // Composite the list front to back.
  BlendBlock pixels(width, height, length);
  for (std::uint32_t entry = 0; entry < length && pixels.live_strips > 0; ++entry) {
    if (entry + kPrefetch < length) __builtin_prefetch(&visible.splats[list[entry + kPrefetch]]);
    pixels.blend(visible.splats[list[entry]], static_cast<float>(x0), static_cast<float>(y0),
                 static_cast<std::int32_t>(entry + 1));
  }

  // Add the background and store the pixels.
  const glm::vec3 background = frame.settings.background;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Strip& strip = pixels.strips[y][x / kLanes];
      const int lane = x % kLanes;
      if (outputs.color) {
        float* pixel = result.color.row(y0 + y) + (x0 + x) * 3;
        pixel[0] = strip.r[lane] + strip.transmittance[lane] * background.x;
        pixel[1] = strip.g[lane] + strip.transmittance[lane] * background.y;
        pixel[2] = strip.b[lane] + strip.transmittance[lane] * background.z;
      }
      if (outputs.evaluated) {
        const auto at =
            static_cast<std::size_t>(y0 + y) * static_cast<std::size_t>(frame.camera.width) +
            static_cast<std::size_t>(x0 + x);
        result.evaluated[at] = static_cast<std::uint32_t>(strip.evaluated[lane]);
      }
    }
  }
}

}  // namespace

void blend(const FrameContext& frame, const Visible& visible, const TileLists& lists,
           const Outputs& outputs, Frame& result) {
  frame.for_frame(static_cast<std::size_t>(blocks_of(frame).count()), 4,
                  [&](std::size_t begin, std::size_t end, int) {
                    for (std::size_t block = begin; block < end; ++block)
                      blend_block(frame, visible, lists, block, outputs, result);
                  });
}

}  // namespace qs::cpu
