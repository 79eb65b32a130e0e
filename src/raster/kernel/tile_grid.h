// SPDX-License-Identifier: MIT
//
// The grid of square tiles over an image, and half-open ranges of tiles. Functions take the side of
// a tile as a template argument, so that the usual kTileSize costs nothing; with_tile_px() calls
// them with the other sizes of the CPU backend.
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

/// Tile sides that the CPU backend supports.
inline constexpr std::array kTileSizes = {8, 16, 32};

/// Calls f(std::integral_constant<int, tile_px>{}). `tile_px` is one of kTileSizes.
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

/// Clamps to [0, limit], limit >= 0, before the cast, because casts out of range differ between
/// host and device. NaN gives 0.
QS_HD int clamp_to_int(float value, int limit) {
  return value > 0.0f ? (value < static_cast<float>(limit) ? static_cast<int>(value) : limit) : 0;
}

/// Tiles t whose open interval (n t, n t + n), n = kTilePx, meets the interval [low, high] of pixel
/// coordinates: floor(low/n) .. ceil(high/n) - 1, clamped to [0, limit).
template <int kTilePx = kTileSize>
QS_HD Span tiles_meeting(float low, float high, int limit) {
  constexpr float kInverse = 1.0f / kTilePx;  // a power of two: exact
  return {clamp_to_int(floorf(low * kInverse), limit), clamp_to_int(ceilf(high * kInverse), limit)};
}

/// Tiles t whose range of pixel centres [n t, n t + n - 1], n = kTilePx, meets [low, high]. May be
/// empty.
template <int kTilePx = kTileSize>
QS_HD Span tiles_with_centers(float low, float high, int limit) {
  constexpr float kInverse = 1.0f / kTilePx;
  return {clamp_to_int(ceilf((low - (kTilePx - 1)) * kInverse), limit),
          clamp_to_int(floorf(high * kInverse) + 1.0f, limit)};
}

/// A half-open rectangle of tiles.
struct TileRect {
  Span columns, rows;

  /// The rectangle of a range of lines and a range of tiles along them; the lines are rows or
  /// columns.
  static QS_HD TileRect of_lines(bool by_rows, Span lines, Span along) {
    return by_rows ? TileRect{along, lines} : TileRect{lines, along};
  }
  QS_HD bool is_empty() const { return columns.size() == 0 || rows.size() == 0; }
  QS_HD bool contains(int column, int row) const {
    return columns.contains(column) && rows.contains(row);
  }
};

QS_HD TileRect intersection(const TileRect& a, const TileRect& b) {
  return {intersection(a.columns, b.columns), intersection(a.rows, b.rows)};
}

}  // namespace qs
