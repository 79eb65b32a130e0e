// SPDX-License-Identifier: MIT
//
// The structs of all culling modes, for code that lists tiles. Everything else asks mode.h. To add
// a mode, include its header and add its struct at the place of its row.
#pragma once

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
#include "raster/kernel/cull/table.h"

namespace qs {

/// In the order of kCullers.
using AllCullers = std::tuple<Square, AdrAabb, DualBox, QuadBoxNaive, QuadBox, Exact,  //
                              SnugBox, AccuTile, FlashGs, StopThePop, FasterGs>;

/// True if the list has the struct of every row but the reference's, in the order of the rows.
template <class... P>
constexpr bool agrees_with_table(const std::tuple<P...>&) {
  if (sizeof...(P) != kModeCount) return false;
  CullMode mode = kReferenceMode;
  return ((kCullers[++mode].name == std::string_view(P::kName)) && ...);
}
static_assert(agrees_with_table(AllCullers()), "AllCullers and table.h differ");

/// The row of struct P, for host code. Device code reads its members as constants only, for example
/// `constexpr bool kKeeps = row_of<P>().keeps_faint`, because the table is in host memory.
template <class P>
constexpr const CullerRow& row_of() {
  return kCullers[number_of(P::kName)];
}

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
