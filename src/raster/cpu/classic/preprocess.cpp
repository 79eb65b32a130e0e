// SPDX-License-Identifier: MIT
// Compiled alone: clang optimises the sanitized walks of all modes for minutes in a larger unit.
#include <glm/geometric.hpp>

#include "raster/cpu/classic/classic.h"
#include "raster/kernel/cull/modes.h"
#include "raster/kernel/sh.h"

namespace qs::cpu {
namespace {

template <class P, int kTilePx>
void preprocess_with(const FrameContext& frame, const ActivatedCloud& active, Visible& visible) {
  const std::size_t size = frame.cloud.size();
  visible.resize(size);
  visible.footprints.resize(visible.slots());
  visible.splats.resize(visible.slots());

  const View<float> view = make_view<float>(frame.camera);
  const FootprintRules rules = frame.rules();
  const int degree = frame.sh_degree();
  const auto coefficient_count =
      static_cast<std::size_t>(sh_coefficient_count(frame.cloud.sh_degree));

  frame.for_chunks(size, Visible::kChunk, [&](std::size_t begin, std::size_t end, int) {
    std::size_t slot = begin;
    for (std::size_t i = begin; i < end; ++i) {
      Projected projected;
      if (!frame.draws(i) || !project(view, rules, active.gaussians[i], projected)) continue;
      if (count_tiles<P, kTilePx>(projected.footprint, frame.grid) == 0) continue;
      const glm::vec3 direction = glm::normalize(frame.cloud.positions[i] - view.position);
      const glm::vec3* sh = frame.cloud.sh.data() + i * coefficient_count;
      const glm::vec3 color = sh_color<float>(degree, direction, [sh](int k) { return sh[k]; });
      visible.gaussians[slot] = static_cast<std::uint32_t>(i);
      visible.depths[slot] = projected.depth;
      visible.footprints[slot] = projected.footprint;
      const float opacity = projected.footprint.is_solid()
                                ? std::exp2(kSolidLog2)
                                : active.opacities[i] * projected.opacity_factor;
      visible.splats[slot] = {make_splat(projected.footprint, opacity, color),
                              PixelBound::of(projected.footprint)};
      ++slot;
    }
    visible.chunk_counts[begin / Visible::kChunk] = static_cast<std::uint32_t>(slot - begin);
  });
  visible.count_all();
}

}  // namespace

void preprocess(const FrameContext& frame, const ActivatedCloud& active, Visible& visible) {
  with_culler(frame.settings.mode, [&]<class P>(P) {
    with_tile_px(frame.grid.tile_px,
                 [&](auto px) { preprocess_with<P, px()>(frame, active, visible); });
  });
}

}  // namespace qs::cpu
