// SPDX-License-Identifier: MIT
//
// The table of culling modes for command line, viewer, benchmarks and tests. To add a mode, add an
// entry to CullerList, or to PeerList if the mode comes from another paper.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <tuple>
#include <utility>

#include "raster/kernel/cull/accu_tile.h"
#include "raster/kernel/cull/adr_aabb.h"
#include "raster/kernel/cull/dual_box.h"
#include "raster/kernel/cull/exact.h"
#include "raster/kernel/cull/faster_gs.h"
#include "raster/kernel/cull/flash_gs.h"
#include "raster/kernel/cull/quad_box.h"
#include "raster/kernel/cull/snug_box.h"
#include "raster/kernel/cull/square.h"
#include "raster/kernel/cull/stop_the_pop.h"

namespace qs {

/// In the order of the viewer's keys 1, 2, 3, ...
using CullerList = std::tuple<Square, AdrAabb, DualBox, QuadBoxNaive, QuadBox, Exact>;

/// The modes of other papers, which tables show on request (`--cull all,+peers`).
using PeerList = std::tuple<SnugBox, AccuTile, FlashGs, StopThePop, FasterGs>;

using AllCullers = decltype(std::tuple_cat(CullerList(), PeerList()));

inline constexpr int kCullerCount = static_cast<int>(std::tuple_size_v<CullerList>);
inline constexpr int kModeCount = static_cast<int>(std::tuple_size_v<AllCullers>);

/// Index of a mode in the table: 1..kCullerCount, kCullerCount + 1..kModeCount for other papers'
/// modes, or 0 for the fp64 reference (CPU only).
using CullMode = int;
inline constexpr CullMode kReferenceMode = 0;

enum class CullerFamily { reference, quadbox, peers };

struct CullerRow {
  const char* name;
  const char* summary;
  bool lossless;
  CullerFamily family;
};

namespace detail {
template <std::size_t... I>
constexpr std::array<CullerRow, sizeof...(I) + 1> make_culler_table(std::index_sequence<I...>) {
  return {CullerRow{"reference", "fp64 without tiles, the image the others are judged against",
                    true, CullerFamily::reference},
          CullerRow{std::tuple_element_t<I, AllCullers>::kName,
                    std::tuple_element_t<I, AllCullers>::kSummary,
                    std::tuple_element_t<I, AllCullers>::kLossless,
                    I < kCullerCount ? CullerFamily::quadbox : CullerFamily::peers}...};
}
}  // namespace detail

/// Index = CullMode.
inline constexpr auto kCullers = detail::make_culler_table(std::make_index_sequence<kModeCount>{});

constexpr const CullerRow& row_of(CullMode mode) {
  return kCullers[static_cast<std::size_t>(mode)];
}

/// The mode's name on the command line.
constexpr const char* mode_name(CullMode mode) { return row_of(mode).name; }

/// The mode with this name; -1 if none has it.
constexpr CullMode find_culler(std::string_view name) {
  for (int mode = 0; mode <= kModeCount; ++mode) {
    if (name == mode_name(mode)) return mode;
  }
  return -1;
}

inline constexpr CullMode kDefaultMode = find_culler("quadbox");

/// Calls f(P{}) with the struct P of `mode`, 1..kModeCount. Host code, called once per frame.
template <int kRow = 1, class F>
decltype(auto) with_culler(CullMode mode, F&& f) {
  using P = std::tuple_element_t<kRow - 1, AllCullers>;
  if constexpr (kRow == kModeCount) {
    return f(P{});
  } else {
    if (mode == kRow) return f(P{});
    return with_culler<kRow + 1>(mode, std::forward<F>(f));
  }
}

}  // namespace qs
