// SPDX-License-Identifier: MIT
//
// A frame between its passes, in memory of the caller: the visible Gaussians with their lists from
// project(), the values of every pixel from blend(). The backward passes only read it, so any
// number of frames may wait for them, and a backward pass may run again or in another thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <type_traits>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "learn/diff/gaussians.h"
#include "raster/cpu/common/tile_lists.h"
#include "raster/kernel/blend.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cpu::diff {

using namespace qs::diff;

/// The threads of a pass, and the token that cancels it.
struct Workers {
  ThreadPool& pool;
  std::stop_token stop = {};

  /// Calls each(i) for i in [0, count), in parallel chunks of `grain`. Throws Cancelled.
  template <class Each>
  void for_each(std::size_t count, std::size_t grain, const Each& each) const {
    pool.for_chunks(count, grain, [&](std::size_t begin, std::size_t end, int) {
      if (stop.stop_requested()) throw Cancelled{};
      for (std::size_t i = begin; i < end; ++i) each(i);
    });
  }
};

/// Conservative bound of the pixels with alpha >= 1/255, row by row: it may include others.
struct PixelArea {
  glm::vec2 mean_px, half_px;  ///< a box around the mean
  float slope;                 ///< in row dy the middle is at dx = slope dy
  float gamma;                 ///< pixels count where a dx^2 + 2 b dx dy + c dy^2 <= gamma
  float by_row, by_column;     ///< 1 / variance of y, and 1 / a

  static PixelArea of(const Footprint& footprint);

  /// Columns of row y.
  float low(float y, float half) const { return mean_px.x + slope * (y - mean_px.y) - half; }
  float high(float y, float half) const { return mean_px.x + slope * (y - mean_px.y) + half; }
  /// Half the length of row y in pixels; < 0 if no pixel of the row counts.
  float half_length(float y) const {
    const float dy = y - mean_px.y;
    const float rest = gamma - dy * dy * by_row;
    return rest > 0 ? std::sqrt(rest * by_column) + 1 : -1;
  }
};

/// Pixels of a full tile.
inline constexpr auto kTilePixels = static_cast<std::size_t>(kTileSize * kTileSize);

/// The pixels of a tile that are inside the image.
struct TileBox {
  int x0, y0, width, height;

  static TileBox of(const PictureSize& size, std::size_t tile) {
    const int columns = size.grid().columns;
    const int x0 = static_cast<int>(tile) % columns * kTileSize;
    const int y0 = static_cast<int>(tile) / columns * kTileSize;
    return {x0, y0, std::min(kTileSize, size.width - x0), std::min(kTileSize, size.height - y0)};
  }

  /// Calls visit(x, y, i) for all pixels; i counts the pixels of a full tile row by row.
  template <class Visit>
  void for_each_pixel(const Visit& visit) const {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        visit(x0 + x, y0 + y, static_cast<std::size_t>(y * kTileSize + x));
  }

  /// Calls visit(x, y, pixel) for the pixels of the area.
  template <class Visit>
  void for_each_pixel(const PixelArea& area, const Visit& visit) const {
    const auto left = static_cast<float>(x0), top = static_cast<float>(y0);
    const float y = area.mean_px.y - top;
    const int end = clamp_to_int(y + area.half_px.y + 1, height);
    for (int row = clamp_to_int(y - area.half_px.y, height); row < end; ++row) {
      const float row_y = top + static_cast<float>(row);
      const float half = area.half_length(row_y);
      if (half < 0) continue;
      const int last = clamp_to_int(area.high(row_y, half) - left + 1, width);
      for (int x = clamp_to_int(area.low(row_y, half) - left, width); x < last; ++x)
        visit(x0 + x, y0 + row, static_cast<std::size_t>(row * kTileSize + x));
    }
  }
};

/// The Gaussians that tiles list. Chunk c of the Gaussians has the slots first[c] to first[c] +
/// counts[c] - 1, by ascending index.
template <class Real>
struct FrameView {
  using Splat = typename PixelMath<Real>::Splat;

  std::span<const std::uint32_t> first, counts;
  std::size_t slots = 0;            ///< above all used slots
  const std::uint32_t* gaussians;   ///< per slot: index of the Gaussian
  const Splat* splats;              ///< per slot
  const PixelArea* areas;           ///< per slot
  const Real* depths;               ///< per slot: view z
  const std::uint64_t* list_begin;  ///< per tile and behind the last tile: begin of its list
  const std::uint32_t* listed;      ///< slots, per tile front to back
  std::size_t pairs = 0;            ///< in all lists

  /// Calls visit(slot) for the slots of a chunk.
  template <class Visit>
  void for_chunk(std::size_t chunk, const Visit& visit) const {
    for (std::uint32_t k = 0; k < counts[chunk]; ++k) visit(std::size_t{first[chunk]} + k);
  }
};

template <class Real>
struct ProjectedFrame {
  using Splat = typename PixelMath<Real>::Splat;

  VisibleSlots visible;              ///< listed in a tile by the culling mode
  std::vector<std::uint32_t> first;  ///< per chunk: its first slot
  std::vector<Splat> splats;         ///< per slot
  std::vector<PixelArea> areas;      ///< per slot
  std::vector<double> depths;        ///< per slot, if Real is double
  DepthOrder order;
  TileLists lists;

  // Per Gaussian.
  std::vector<std::uint8_t> in_view;    ///< see is_in_view() of kernel/cull/in_view.h
  std::vector<std::uint8_t> listed;     ///< 1 if the culling mode lists it in a tile
  std::vector<std::uint8_t> projected;  ///< 1 if it has a row in Boundary; not filled in training

  FrameView<Real> view() const {
    const Real* depth = nullptr;
    if constexpr (std::is_same_v<Real, float>)
      depth = visible.depths.data();
    else
      depth = depths.data();
    return {first,
            visible.chunk_counts,
            visible.slots(),
            visible.gaussians.data(),
            splats.data(),
            areas.data(),
            depth,
            lists.begin.data(),
            lists.slots.data(),
            lists.pairs()};
  }
};

/// The values of every pixel, row by row, that the backward pass reads.
template <class Real>
struct PixelState {
  using Count = std::conditional_t<std::is_const_v<Real>, const std::uint32_t, std::uint32_t>;

  Real* color;          ///< `channels` each, over the background, not clamped
  Real* transmittance;  ///< behind the last Gaussian
  Count* last;          ///< entries of the tile's list up to the last blended entry
  Real* depth;          ///< sum of z by weight; null if blend() does not compute it
  Real* inverse_depth;  ///< sum of 1 / z by weight; null like `depth`
};

/// Owns the arrays that PixelState points to.
template <class Real>
struct BlendedFrame {
  std::vector<Real> color, transmittance;
  std::vector<std::uint32_t> last;
  std::vector<Real> depth, inverse_depth;  ///< empty if blend() does not compute them

  void resize(const PictureSize& size, int channels, bool with_depth) {
    const std::size_t pixels = size.pixels();
    color.resize(pixels * static_cast<std::size_t>(channels));
    transmittance.resize(pixels);
    last.resize(pixels);
    depth.resize(with_depth ? pixels : 0);
    inverse_depth.resize(with_depth ? pixels : 0);
  }
  PixelState<Real> state() { return state_of<Real>(*this); }
  PixelState<const Real> state() const { return state_of<const Real>(*this); }

 private:
  template <class T, class Self>
  static PixelState<T> state_of(Self& self) {
    const bool deep = !self.depth.empty();
    return {self.color.data(), self.transmittance.data(), self.last.data(),
            deep ? self.depth.data() : nullptr, deep ? self.inverse_depth.data() : nullptr};
  }
};

}  // namespace qs::cpu::diff
