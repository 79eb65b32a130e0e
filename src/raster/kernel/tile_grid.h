// SPDX-License-Identifier: MIT
//
// The image cut into square tiles, and ranges of tiles. All ranges are half-open.
// The side of a tile is a template argument of whatever decides: it is kTileSize, unless somebody
// asks the CPU backend for another one (with_tile_px), and costs nothing where nobody does.
#pragma once

#include <array>
#include <cmath>
#include <type_traits>

#include "raster/kernel/constants.h"
#include "raster/kernel/hd.h"

namespace qs {

struct TileGrid {
  int columns = 0, rows = 0;
  int tile_px = kTileSize;  ///< side of a tile

  static QS_HD TileGrid of_image(int width, int height, int tile_px = kTileSize) {
    return {(width + tile_px - 1) / tile_px, (height + tile_px - 1) / tile_px, tile_px};
  }
  QS_HD int count() const { return columns * rows; }
  QS_HD int tile_of(int x, int y) const { return y / tile_px * columns + x / tile_px; }
};

/// Sides of tiles that the CPU backend knows.
inline constexpr std::array kTileSizes = {8, 16, 32};

/// Calls f(std::integral_constant<int, tile_px>{}); one of kTileSizes.
template <class F>
decltype(auto) with_tile_px(int tile_px, F&& f) {
  if (tile_px == kTileSizes[0]) return f(std::integral_constant<int, kTileSizes[0]>{});
  if (tile_px == kTileSizes[2]) return f(std::integral_constant<int, kTileSizes[2]>{});
  return f(std::integral_constant<int, kTileSizes[1]>{});
}

/// Tiles [begin, end) along one axis; empty when begin >= end.
struct Span {
  int begin, end;
  QS_HD int size() const { return end > begin ? end - begin : 0; }
  QS_HD bool contains(int tile) const { return tile >= begin && tile < end; }
};

QS_HD Span intersection(Span a, Span b) {
  return {a.begin > b.begin ? a.begin : b.begin, a.end < b.end ? a.end : b.end};
}

/// A float clamped to [0, limit] and then cast: host and device casts differ out of range. NaN
/// gives 0.
QS_HD int clamp_to_int(float value, int limit) {
  return value > 0.0f ? (value < static_cast<float>(limit) ? static_cast<int>(value) : limit) : 0;
}

/// Tiles whose open interval (16t, 16t+16) meets the interval [low, high] of pixel coordinates:
/// floor(low/16) .. ceil(high/16) - 1, clamped to [0, limit). For 16 read kTilePx.
template <int kTilePx = kTileSize>
QS_HD Span tiles_meeting(float low, float high, int limit) {
  constexpr float kInverse = 1.0f / kTilePx;  // a power of two: exact
  return {clamp_to_int(floorf(low * kInverse), limit), clamp_to_int(ceilf(high * kInverse), limit)};
}

/// Tiles with a pixel centre coordinate range [16t, 16t+15] that meets [low, high]; may be empty.
template <int kTilePx = kTileSize>
QS_HD Span tiles_with_centers(float low, float high, int limit) {
  constexpr float kInverse = 1.0f / kTilePx;
  return {clamp_to_int(ceilf((low - (kTilePx - 1)) * kInverse), limit),
          clamp_to_int(floorf(high * kInverse) + 1.0f, limit)};
}

/// A half-open rectangle of tiles.
struct TileRect {
  Span columns, rows;
  QS_HD bool contains(int column, int row) const {
    return columns.contains(column) && rows.contains(row);
  }
};

}  // namespace qs
