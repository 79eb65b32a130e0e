// SPDX-License-Identifier: MIT
//
// A frame between its passes, in memory of the caller: the visible Gaussians with their lists from
// project(), the values of every pixel from blend(). The backward passes only read it, so any
// number of frames may wait for them, and a backward pass may run again or in another thread.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "learn/diff/cpu/picture.h"
#include "raster/cpu/common/bin.h"
#include "raster/kernel/blend.h"

namespace qs::cpu::diff {

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
