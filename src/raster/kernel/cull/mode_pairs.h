// SPDX-License-Identifier: MIT
//
// The number of tiles that every mode of `--cull all` lists, for Outputs::mode_pairs. One footprint
// serves all modes: project() with keep_faint keeps the Gaussians of all modes, and each mode then
// counts the Gaussians that its own frame would keep. A new mode is counted without changes here.
#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include "raster/kernel/cull/modes.h"

namespace qs {

/// The struct of a mode, 1..kModeCount.
template <CullMode kMode>
using CullerOf = std::tuple_element_t<static_cast<std::size_t>(kMode - 1), AllCullers>;

/// The mode that counts for mode P: P itself, or P::SameTiles.
template <class P>
constexpr CullMode counting_mode() {
  if constexpr (requires { typename P::SameTiles; }) {
    using Same = typename P::SameTiles;
    static_assert(row_of<P>().keeps_faint == row_of<Same>().keeps_faint);
    return number_of(Same::kName);
  } else {
    return number_of(P::kName);
  }
}

template <CullMode kMode>
inline constexpr CullMode kCountingMode = counting_mode<CullerOf<kMode>>();

/// True if the mode counts for itself.
template <CullMode kMode>
inline constexpr bool kCountsItself = kCountingMode<kMode> == kMode;

template <class P>
inline constexpr bool kKeepsFaint = row_of<P>().keeps_faint;

/// True if frames of mode P list a Gaussian of this gamma.
template <class P>
QS_HD bool keeps(float gamma) {
  return kKeepsFaint<P> || gamma > 0.0f;
}

/// The tiles of one Gaussian; index = mode - 1.
struct TilesOfModes {
  unsigned tiles[kCullerCount];
};

namespace detail {

template <int kTilePx, int... kIndex>
QS_HD TilesOfModes tiles_of_modes(const Footprint& footprint, TileGrid grid,
                                  std::integer_sequence<int, kIndex...>) {
  TilesOfModes all{};
  const auto count = [&]<int kMode>(std::integral_constant<int, kMode>) {
    using P = CullerOf<kMode>;
    if constexpr (kCountsItself<kMode>) {
      if (keeps<P>(footprint.gamma))
        all.tiles[kMode - 1] = count_tiles<P, kTilePx>(footprint, grid);
    }
  };
  (count(std::integral_constant<int, kIndex + 1>()), ...);
  ((all.tiles[kIndex] = all.tiles[kCountingMode<kIndex + 1> - 1]), ...);
  return all;
}

}  // namespace detail

/// `footprint` is the result of project() with keep_faint.
template <int kTilePx = kTileSize>
QS_HD TilesOfModes tiles_of_modes(const Footprint& footprint, TileGrid grid) {
  return detail::tiles_of_modes<kTilePx>(footprint, grid,
                                         std::make_integer_sequence<int, kCullerCount>());
}

/// Sums over Gaussians; index = mode - 1. The type of atomicAdd() on CUDA.
struct ModeCounts {
  unsigned long long tile_pairs[kCullerCount];
  unsigned visible[kCullerCount];  ///< Gaussians with at least one tile
};

}  // namespace qs
