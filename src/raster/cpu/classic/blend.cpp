// SPDX-License-Identifier: MIT
#include <algorithm>
#include <memory>

#include "raster/cpu/classic/classic.h"

namespace qs::cpu {
namespace {

/// Prefetch distance in list entries. Neighbours in a list are scattered in memory.
constexpr std::uint64_t kPrefetch = 6;

/// Pixels side by side that are composited together. Arrays have this fixed length so that
/// compilers vectorise the loops over lanes.
constexpr int kLanes = 8;
constexpr int kMostPx = kTileSizes.back();

/// A Gaussian in the list of a tile.
struct ListEntry {
  const BoundedSplat& bounded;
  std::int32_t number;  ///< 1-based position in the list
};

/// The effect of a Gaussian on a pixel. Both transmittances are given: in front of it and behind
/// it.
struct Effect {
  float weight, before, behind;
  std::int32_t blends, stops;  ///< 1 or 0
};

/// The values of a strip of pixels for Outputs::color and Outputs::evaluated.
struct ColorSums {
  float r[kLanes], g[kLanes], b[kLanes];
  std::int32_t stopped_at[kLanes];  ///< number of the entry at which the pixel stopped, else 0

  void add(int lane, const ListEntry& entry, const Effect& effect) {
    const glm::vec3& color = entry.bounded.splat.color;
    r[lane] += effect.weight * color.x;
    g[lane] += effect.weight * color.y;
    b[lane] += effect.weight * color.z;
    stopped_at[lane] = effect.stops != 0 ? entry.number : stopped_at[lane];
  }
};

struct NoSums {
  void add(int, const ListEntry&, const Effect&) {}
};

template <class Sums>
struct Strip {
  Sums sums;
  float transmittance[kLanes];
  std::int32_t live[kLanes];  ///< 1 until the pixel stops, then 0; 0 outside of the image
  int live_count;

  /// Composites a Gaussian as kernel/composite.h does. (dx, dy) is the first pixel minus the mean.
  /// Returns 1 if a pixel blends it.
  std::int32_t composite(const ListEntry& entry, float dx, float dy) {
    const Splat& splat = entry.bounded.splat;
    std::int32_t stops = 0, used = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      const float power = log2_falloff(splat, dx + static_cast<float>(lane), dy);
      const float alpha = alpha_of(splat, power);
      const float before = transmittance[lane], next = before * (1.0f - alpha);
      const std::int32_t counts =
          live[lane] & std::int32_t(power <= 0.0f) & std::int32_t(alpha >= kAlphaMin);
      const std::int32_t stop = counts & std::int32_t(next < kTransmittanceMin);
      const std::int32_t use = counts & ~stop;
      sums.add(lane, entry, {use != 0 ? alpha * before : 0.0f, before, next, use, stop});
      transmittance[lane] = use != 0 ? next : before;
      live[lane] &= ~stop;
      stops += stop;
      used |= use;
    }
    live_count -= stops;
    return used;
  }
};

/// The pixels of a tile while they are composited. Coordinates start at its corner.
template <class Sums>
struct Tile {
  int x0, y0, width, height, live;  ///< live: pixels that have not stopped
  std::uint32_t used;               ///< list entries that a pixel blends
  Strip<Sums> strips[kMostPx][kMostPx / kLanes];

  void begin(const FrameContext& frame, std::size_t tile) {
    const int tile_px = frame.grid.tile_px;
    x0 = static_cast<int>(tile) % frame.grid.columns * tile_px;
    y0 = static_cast<int>(tile) / frame.grid.columns * tile_px;
    width = std::min(tile_px, frame.camera.width - x0);
    height = std::min(tile_px, frame.camera.height - y0);
    live = width * height;
    used = 0;
    for (int y = 0; y < height; ++y) {
      for (int s = 0; s < tile_px / kLanes; ++s) {
        Strip<Sums>& strip = strips[y][s];
        strip.sums = {};
        strip.live_count = std::clamp(width - s * kLanes, 0, kLanes);
        std::fill_n(strip.transmittance, kLanes, 1.0f);
        for (int lane = 0; lane < kLanes; ++lane) strip.live[lane] = lane < strip.live_count;
      }
    }
  }

  void composite(const ListEntry& entry) {
    const BoundedSplat& bounded = entry.bounded;
    const glm::vec2 half = bounded.bound.half;
    const glm::vec2 mean = bounded.splat.mean_px - glm::vec2(x0, y0);
    const Span columns{clamp_to_int(mean.x - half.x, width),
                       clamp_to_int(mean.x + half.x + 1, width)};
    const Span rows{clamp_to_int(mean.y - half.y, height),
                    clamp_to_int(mean.y + half.y + 1, height)};
    if (columns.begin >= columns.end || !(half.y > 0.0f)) return;
    std::int32_t any = 0;
    for (int y = rows.begin; y < rows.end; ++y) {
      const float dy = static_cast<float>(y0 + y) - bounded.splat.mean_px.y;
      for (int s = columns.begin / kLanes; s <= (columns.end - 1) / kLanes; ++s) {
        Strip<Sums>& strip = strips[y][s];
        const float dx = static_cast<float>(x0 + s * kLanes) - bounded.splat.mean_px.x;
        if (strip.live_count == 0 || !touches(bounded, dx, dy, kLanes)) continue;
        const int before = strip.live_count;
        any |= strip.composite(entry, dx, dy);
        live -= before - strip.live_count;
      }
    }
    used += static_cast<std::uint32_t>(any);
  }

  /// Calls visit(x, y, strip, lane) for the pixels inside the image, with coordinates in the image.
  template <class Visit>
  void for_each_pixel(const Visit& visit) const {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) visit(x0 + x, y0 + y, strips[y][x / kLanes], x % kLanes);
  }
};

/// The body of a parallel loop over tiles: composites each until all its pixels have stopped, and
/// calls store(index, tile).
template <class Sums, class Store>
auto composites_tiles(const FrameContext& frame, const Visible& visible, const TileLists& lists,
                      const Store& store) {
  return [&, store](std::size_t begin, std::size_t end, int) {
    const auto tile = std::make_unique<Tile<Sums>>();
    for (std::size_t index = begin; index < end; ++index) {
      tile->begin(frame, index);
      const std::uint32_t* const list = lists.slots.data() + lists.begin[index];
      const std::uint32_t length = lists.pairs(index);
      for (std::uint32_t k = 0; k < length && tile->live > 0; ++k) {
        if (k + kPrefetch < length) __builtin_prefetch(&visible.splats[list[k + kPrefetch]]);
        tile->composite({visible.splats[list[k]], static_cast<std::int32_t>(k + 1)});
      }
      store(index, *tile);
    }
  };
}

constexpr std::size_t kGrain = 4;  // tiles

}  // namespace

void blend(const FrameContext& frame, const Visible& visible, const TileLists& lists,
           const Outputs& outputs, Frame& result) {
  const glm::vec3 background = frame.settings.background;
  const auto store = [&](std::size_t index, const Tile<ColorSums>& tile) {
    const std::uint32_t length = lists.pairs(index);
    tile.for_each_pixel([&](int x, int y, const Strip<ColorSums>& strip, int lane) {
      const ColorSums& sums = strip.sums;
      if (outputs.color) {
        float* pixel = result.color.row(y) + x * 3;
        pixel[0] = sums.r[lane] + strip.transmittance[lane] * background.x;
        pixel[1] = sums.g[lane] + strip.transmittance[lane] * background.y;
        pixel[2] = sums.b[lane] + strip.transmittance[lane] * background.z;
      }
      if (outputs.evaluated) {
        const auto stopped_at = static_cast<std::uint32_t>(sums.stopped_at[lane]);
        result.evaluated[frame.pixel(x, y)] = stopped_at > 0 ? stopped_at : length;
      }
    });
  };
  frame.for_frame(static_cast<std::size_t>(frame.grid.count()), kGrain,
                  composites_tiles<ColorSums>(frame, visible, lists, store));
}

void Classic::count_used(const FrameContext& frame, Frame& result) const {
  const auto tiles = static_cast<std::size_t>(frame.grid.count());
  result.used.resize(tiles);
  const auto store = [&](std::size_t index, const Tile<NoSums>& tile) {
    result.used[index] = tile.used;
  };
  frame.for_chunks(tiles, kGrain, composites_tiles<NoSums>(frame, visible_, lists_, store));
  result.stats.used_pairs = sum_of(result.used);
}

}  // namespace qs::cpu
