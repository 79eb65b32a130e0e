// SPDX-License-Identifier: MIT
#include <type_traits>

#include "raster/cpu/fast/pipeline.h"
#include "raster/cpu/fast/survivors.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/mode_pairs.cpp"
// clang-format off
#include "base/simd.h"
#include "raster/cpu/fast/walk_vectors.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {

/// The tiles of a walk's first `lines` lines.
template <class AnyWalk>
HWY_INLINE I tiles_in_lines(const AnyWalk& walk, I lines) {
  const DI di;
  if constexpr (std::is_base_of_v<WalkOfRect, AnyWalk>) {
    const WalkOfRect& rect = walk;
    return hn::Mul(lines, rect.tiles.size());
  } else {
    I sum = hn::Zero(di);
    for (int line = 0;; ++line) {
      const auto exists = hn::Gt(lines, hn::Set(di, line));
      if (hn::AllFalse(di, exists)) return sum;
      const Spans span = walk.span(hn::Add(walk.lines.begin, hn::Set(di, line)));
      sum = hn::Add(sum, hn::IfThenElseZero(exists, span.size()));
    }
  }
}

/// Sets the tiles of every survivor in mode P, by vectors.
template <class P>
HWY_INLINE void count_by_vectors(TileGrid grid, const Survivors& s, std::int32_t* tiles) {
  const DI di;
  for (std::size_t k = 0; k < s.count; k += hn::Lanes(di)) {
    const Footprints footprints(s, k);
    const Walk<P> walk(footprints, grid);
    auto counted = hn::FirstN(di, s.count - k);
    if constexpr (!kKeepsFaint<P>)
      counted = hn::And(counted, hn::RebindMask(di, hn::Gt(footprints.gamma, hn::Zero(D()))));
    const I lines = hn::IfThenElseZero(counted, walk.lines.size());
    hn::Store(tiles_in_lines(walk, lines), di, tiles + k);
  }
}

template <class P>
HWY_INLINE void count_mode(CullMode mode, TileGrid grid, const Survivors& s, ModeCounts& counts) {
  alignas(64) std::int32_t tiles[kBlock];
  if constexpr (HasVectors<P>) {
    count_by_vectors<P>(grid, s, tiles);
  } else {
    for (std::size_t k = 0; k < s.count; ++k) {
      const bool counted = keeps<P>(s.gamma[k]);
      tiles[k] = counted ? static_cast<int>(count_tiles<P>(s.footprint(k), grid)) : 0;
    }
  }
  std::uint64_t pairs = 0;
  std::uint32_t visible = 0;
  for (std::size_t k = 0; k < s.count; ++k) {
    pairs += static_cast<std::uint32_t>(tiles[k]);
    visible += tiles[k] != 0 ? 1 : 0;
  }
  counts.tile_pairs[mode - 1] += pairs;
  counts.visible[mode - 1] += visible;
}

template <int kMode = 1>
HWY_INLINE void count_from(TileGrid grid, const Survivors& s, ModeCounts& counts) {
  using P = CullerOf<kMode>;
  if constexpr (kCountsItself<kMode>) count_mode<P>(kMode, grid, s, counts);
  if constexpr (kMode < kCullerCount) count_from<kMode + 1>(grid, s, counts);
  if constexpr (!kCountsItself<kMode>) {
    counts.tile_pairs[kMode - 1] = counts.tile_pairs[kCountingMode<kMode> - 1];
    counts.visible[kMode - 1] = counts.visible[kCountingMode<kMode> - 1];
  }
}

void count_block(TileGrid grid, const Survivors& survivors, ModeCounts& counts) {
  count_from(grid, survivors, counts);
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(count_block);

void FastPipeline::count_modes(const FrameContext& counted, ModeSums& sums) const {
  constexpr std::size_t kGrain = 8;  // blocks
  const View<float> view = make_view<float>(counted.camera);
  FootprintRules rules = counted.rules();
  rules.keep_faint = true;
  const Frustum frustum(view, rules, counted.grid);
  counted.for_chunks(
      scene_.blocks.size(), kGrain, [&](std::size_t begin, std::size_t end, int worker) {
        ModeCounts counts{};
        Survivors survivors;
        for (std::size_t b = begin; b < end; ++b) {
          if (!scene_.shows(frustum, b)) continue;
          project(view, rules, counted.grid, scene_.blocks[b], scene_.drawn_in(b), survivors);
          HWY_DYNAMIC_DISPATCH(count_block)(counted.grid, survivors, counts);
        }
        sums.add(worker, counts);
      });
}

}  // namespace qs::cpu::fast
#endif
