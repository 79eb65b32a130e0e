// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/mode_pairs.h"

#include "raster/cpu/fast/project.h"
#include "raster/cpu/fast/walks.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/mode_pairs.cpp"
#include "raster/cpu/fast/simd.h"

// The walks are vectors; the loops here are compiled for every instruction set, so that the
// compiler vectorises them.
HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {

/// The tiles in the first lines of each survivor's walk.
HWY_INLINE void add_lines(const Walks& walks, std::size_t count, std::uint32_t* tiles) {
  for (std::size_t k = 0; k < count; ++k) {
    const std::int32_t lines = walks.lines_end[k] - walks.lines_begin[k];
    std::int32_t sum = 0;
    for (int i = 0; i < Walks::kLines; ++i) {
      const std::int32_t run = walks.end[i][k] - walks.begin[i][k];
      sum += i < lines && run > 0 ? run : 0;
    }
    tiles[k] = static_cast<std::uint32_t>(sum);
  }
}

template <class P>
HWY_INLINE void count_mode(CullMode mode, TileGrid grid, const Survivors& s, ModeCounts& counts) {
  Walks walks;
  alignas(64) std::uint32_t tiles[kBlock];
  const bool computed = walks.compute(mode, grid, s);
  if (computed) add_lines(walks, s.count, tiles);
  std::uint64_t pairs = 0;
  std::uint32_t visible = 0;
  for (std::size_t k = 0; k < s.count; ++k) {
    if (!keeps<P>(s.gamma[k])) continue;
    const bool counted = computed && walks.has_all_spans(k);
    const std::uint32_t own = counted ? tiles[k] : number_of_tiles<P>(s.footprint(k), grid);
    pairs += own;
    visible += own > 0 ? 1 : 0;
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

void count_modes(const FrameContext& frame, const SceneBlocks& scene, ModeSums& sums) {
  constexpr std::size_t kGrain = 8;  // blocks
  const View<float> view = make_view<float>(frame.camera);
  FootprintRules rules = frame.rules();
  rules.keep_faint = true;
  const Frustum frustum(view, rules, frame.grid);
  frame.for_chunks(scene.blocks.size(), kGrain,
                   [&](std::size_t begin, std::size_t end, int worker) {
                     ModeCounts counts{};
                     Survivors survivors;
                     for (std::size_t b = begin; b < end; ++b) {
                       if (frustum.misses(scene.bounds[b])) continue;
                       project(view, rules, frame.grid, scene.blocks[b], survivors);
                       HWY_DYNAMIC_DISPATCH(count_block)(frame.grid, survivors, counts);
                     }
                     sums.add(worker, counts);
                   });
}

}  // namespace qs::cpu::fast
#endif
