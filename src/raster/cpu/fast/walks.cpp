// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/walks.h"

#include "raster/kernel/cull/modes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/walks.cpp"
// clang-format off
#include "base/simd.h"
#include "raster/cpu/fast/walk_vectors.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
template <class P>
HWY_INLINE void compute_with(TileGrid grid, const Survivors& s, Walks& walks) {
  const DI di;
  for (std::size_t k = 0; k < s.count; k += hn::Lanes(di)) {
    const Walk<P> walk(Footprints(s, k), grid);
    hn::Store(hn::VecFromMask(di, hn::RebindMask(di, walk.by_rows)), di, walks.by_rows + k);
    hn::Store(walk.lines.begin, di, walks.lines_begin + k);
    hn::Store(walk.lines.end, di, walks.lines_end + k);
    for (int line = 0; line < Walks::kLines; ++line) {
      const Spans span = walk.span(hn::Add(walk.lines.begin, hn::Set(di, line)));
      hn::Store(span.begin, di, walks.begin[line] + k);
      hn::Store(span.end, di, walks.end[line] + k);
    }
  }
}

bool compute_walks(CullMode mode, TileGrid grid, const Survivors& s, Walks& walks) {
  return with_culler(mode, [&]<class P>(P) HWY_ATTR {
    if constexpr (HasVectors<P>) compute_with<P>(grid, s, walks);
    return HasVectors<P>;
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(compute_walks);

bool Walks::compute(CullMode mode, TileGrid grid, const Survivors& survivors) {
  return HWY_DYNAMIC_DISPATCH(compute_walks)(mode, grid, survivors, *this);
}

}  // namespace qs::cpu::fast
#endif
