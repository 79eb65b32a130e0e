// SPDX-License-Identifier: MIT
//
// The first half of project(), for every source of Gaussians: finds the Gaussians that the view
// shows and stores the input of their pixels. Lists are decided in single precision as in every
// frame, also when Real is double.
//
// A source has these members for Gaussian i:
//   bool exists(i)                        false: it is not drawn
//   glm::vec<3, Real> mean(i)
//   Covariance3<double> covariance(i)     world units^2
//   double opacity(i)
//   glm::vec<3, Real> color(i, mean)      as pixels read it
// and, if its kReports is true,
//   bool report(i, projected, values, color)   false: it is not drawn after all
#pragma once

#include <type_traits>

#include "learn/diff/cpu/frame.h"
#include "learn/diff/gaussian_terms.h"
#include "raster/kernel/cull/in_view.h"
#include "raster/scene/activated_cloud.h"

namespace qs::cpu::diff {

/// Counts the tiles that a culling mode lists.
using CountTiles = unsigned (*)(const Footprint& footprint, TileGrid grid);
CountTiles tile_counter(CullMode mode);

/// `single` has the members of FootprintRules, `rules` has the members of GradientRules<Real>.
template <class Real, class SingleRules, class Rules, class Source>
void project_gaussians(const FrameContext& context, const View<float>& rounded_view,
                       SingleRules single, const Rules& rules, const Source& source,
                       std::size_t count, ProjectedFrame<Real>& frame) {
  VisibleSlots& visible = frame.visible;
  visible.resize(count);
  visible.footprints.resize(visible.slots());
  frame.splats.resize(visible.slots());
  frame.areas.resize(visible.slots());
  if constexpr (std::is_same_v<Real, double>) frame.depths.resize(visible.slots());
  frame.in_view.assign(count, 0);
  frame.listed.assign(count, 0);
  frame.projected.assign(Source::kReports ? count : 0, 0);
  // A source may report Gaussians that are too faint to be drawn.
  const bool keeps_faint = single.keep_faint;
  single.keep_faint = true;
  const CountTiles count_tiles = tile_counter(context.settings.mode);

  context.for_chunks(count, VisibleSlots::kChunk, [&](std::size_t begin, std::size_t end, int) {
    std::size_t slot = begin;
    for (std::size_t i = begin; i < end; ++i) {
      if (!source.exists(i)) continue;
      // Activate and project.
      const glm::vec<3, Real> mean = source.mean(i);
      const Covariance3<double> sigma = source.covariance(i);
      const double opacity = source.opacity(i);
      Projected projected;
      if (!project(rounded_view, single, activate(glm::vec3(mean), sigma, opacity).gaussian,
                   projected))
        continue;
      const auto values = [&] {
        return SplatValues<Real>::of(rules, mean, sigma, opacity, projected);
      };
      glm::vec<3, Real> color(0);
      if constexpr (Source::kReports) {
        color = source.color(i, mean);
        if (!source.report(i, projected, values(), color)) continue;
        frame.projected[i] = 1;
      }
      // Drop Gaussians without tiles.
      if (!keeps_faint && !(projected.footprint.gamma > 0.0f)) continue;
      frame.in_view[i] = is_in_view(projected.footprint, context.grid);
      if (count_tiles(projected.footprint, context.grid) == 0) continue;
      frame.listed[i] = 1;
      // Evaluate the colour and store the Gaussian in the next slot.
      if constexpr (!Source::kReports) color = source.color(i, mean);
      const SplatValues<Real> v = values();
      visible.gaussians[slot] = static_cast<std::uint32_t>(i);
      visible.depths[slot] = projected.depth;
      visible.footprints[slot] = projected.footprint;
      frame.areas[slot] = PixelArea::of(projected.footprint);
      frame.splats[slot] = make_splat(v.mean_px, v.conic, v.opacity, color);
      if constexpr (std::is_same_v<Real, double>) frame.depths[slot] = v.depth;
      ++slot;
    }
    visible.chunk_counts[begin / VisibleSlots::kChunk] = static_cast<std::uint32_t>(slot - begin);
  });
  visible.count_all();
  frame.first.resize(visible.chunk_counts.size());
  for (std::size_t chunk = 0; chunk < frame.first.size(); ++chunk)
    frame.first[chunk] = static_cast<std::uint32_t>(chunk * VisibleSlots::kChunk);
}

/// The second half: sorts and lists them. Throws Cancelled, and Error(device) if the tile lists do
/// not fit into memory.
template <class Real>
void list_gaussians(const FrameContext& context, ProjectedFrame<Real>& frame) {
  sort(context, frame.visible, frame.order);
  bin(context, frame.visible, frame.order, frame.lists);
}

}  // namespace qs::cpu::diff
