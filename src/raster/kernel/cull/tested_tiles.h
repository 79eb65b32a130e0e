// SPDX-License-Identifier: MIT
//
// The walk shared by the modes that test tile by tile: FlashGS, StopThePop and Faster-GS.
#pragma once

#include "raster/kernel/cull/culler.h"

namespace qs {

/// A walk over the tiles of a rectangle that pass Test::meets(column, row). An ellipse meets a line
/// of tiles in one run, so the tiles are tested from both ends of a line until one passes.
template <class Test>
struct TestedWalk {
  bool by_rows;
  Span lines;
  Span tiles;
  Test test;

  static QS_HD TestedWalk over(const TileRect& rect, const Test& test) {
    const RectWalk box = RectWalk::over(rect);
    return {box.by_rows, box.lines, box.tiles, test};
  }
  QS_HD Span span(int line) const {
    Span run = tiles;
    while (run.begin < run.end && !meets(line, run.begin)) ++run.begin;
    while (run.begin < run.end && !meets(line, run.end - 1)) --run.end;
    return run;
  }
  QS_HD Span widest() const { return tiles; }

 private:
  QS_HD bool meets(int line, int tile) const {
    return by_rows ? test.meets(tile, line) : test.meets(line, tile);
  }
};

/// Tiles of the ellipse's axis-aligned box mean +- sqrt(gamma Sigma), without the widening of
/// extents().
template <int kTilePx>
QS_HD TileRect tiles_of_plain_box(const Footprint& footprint, TileGrid grid) {
  const Covariance2<float>& s = footprint.covariance;
  const glm::vec2 half(sqrtf(footprint.gamma * s.xx), sqrtf(footprint.gamma * s.yy));
  return tiles_of_box<kTilePx>(footprint.mean_px, half, grid);
}

}  // namespace qs
