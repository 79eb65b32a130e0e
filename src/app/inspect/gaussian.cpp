// SPDX-License-Identifier: MIT
#include "app/inspect/gaussian.h"

#include <algorithm>
#include <cmath>

#include "raster/kernel/cull/modes.h"

namespace qs {
namespace {

/// Eigenvalues of the covariance, the larger one first.
glm::dvec2 eigenvalues(const Covariance2<float>& c) {
  const double xx = static_cast<double>(c.xx), xy = static_cast<double>(c.xy),
               yy = static_cast<double>(c.yy);
  const double mid = 0.5 * (xx + yy), root = std::hypot(0.5 * (xx - yy), xy);
  // det / larger avoids the cancellation of mid - root for thin ellipses.
  return {mid + root, (xx * yy - xy * xy) / (mid + root)};
}

bool keeps(CullMode mode, const Footprint& footprint) {
  return footprint.gamma > 0 || row_of(mode).keeps_faint;
}

Box quadrant_box(glm::vec2 mean, glm::vec2 reach, int quadrant) {
  const bool right = (quadrant & 1) != 0, below = (quadrant & 2) != 0;
  return {{right ? mean.x : mean.x - reach.x, below ? mean.y : mean.y - reach.y},
          {right ? mean.x + reach.x : mean.x, below ? mean.y + reach.y : mean.y}};
}

void add_boxes(GaussianReport& report) {
  const Footprint& footprint = report.footprint;
  const glm::vec2 mean = footprint.mean_px, radius(Square::radius(footprint));
  report.square = {mean - radius, mean + radius};
  if (!report.visible) return;
  const Extents e = extents(footprint);
  report.f = e.f;
  report.adr = {mean - e.max, mean + e.max};
  const QuadBoxes boxes = QuadBoxes::of(footprint);
  const bool major_is_same = footprint.conic.y < 0;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    report.quad_boxes.push_back(quadrant_box(mean, boxes.reach(quadrant), quadrant));
    const bool same = quadrant == 0 || quadrant == 3;
    if (same == major_is_same) report.dual_boxes.push_back(report.quad_boxes.back());
  }
}

}  // namespace

float anisotropy_of(const Footprint& footprint) {
  const glm::dvec2 variances = eigenvalues(footprint.covariance);
  return static_cast<float>(std::sqrt(variances.x / variances.y));
}

float tilt_of(const Footprint& footprint) {
  const Covariance2<float>& c = footprint.covariance;
  return 0.5f * std::atan2(2 * c.xy, c.xx - c.yy);
}

float screen_radius_of(const Footprint& footprint) {
  if (!(footprint.gamma > 0)) return 0;
  return static_cast<float>(
      std::sqrt(static_cast<double>(footprint.gamma) * eigenvalues(footprint.covariance).x));
}

std::vector<glm::vec2> ellipse_of(const Footprint& footprint, int count) {
  const glm::dvec2 half = glm::sqrt(static_cast<double>(std::max(footprint.gamma, 0.0f)) *
                                    eigenvalues(footprint.covariance));
  const double tilt = static_cast<double>(tilt_of(footprint));
  std::vector<glm::vec2> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    const double along = half.x * std::cos(angle), across = half.y * std::sin(angle);
    points.push_back(footprint.mean_px +
                     glm::vec2(along * std::cos(tilt) - across * std::sin(tilt),
                               along * std::sin(tilt) + across * std::cos(tilt)));
  }
  return points;
}

ModeTiles mode_tiles(CullMode mode, const Footprint& footprint, const TileGrid& grid) {
  ModeTiles result;
  result.mode = mode;
  if (!keeps(mode, footprint)) return result;
  with_culler(mode, [&]<class P>(P) {
    with_tile_px(grid.tile_px, [&](auto px) {
      for_each_tile<P, px()>(footprint, grid, [&](int tile) { result.tiles.push_back(tile); });
      if constexpr (requires { P::template walk<px()>(footprint, grid); }) {
        const auto walk = P::template walk<px()>(footprint, grid);
        result.walks_rows = walk.by_rows;
        for_each_line(walk, [&](int line, Span span) { result.runs.push_back({line, span}); });
      }
    });
  });
  return result;
}

std::uint32_t count_mode_tiles(CullMode mode, const Footprint& footprint, const TileGrid& grid) {
  if (!keeps(mode, footprint)) return 0;
  return with_culler(mode, [&]<class P>(P) {
    return with_tile_px(grid.tile_px,
                        [&](auto px) { return count_tiles<P, px()>(footprint, grid); });
  });
}

GaussianReport inspect_gaussian(const Trace& trace, std::size_t slot, const TileGrid& grid) {
  GaussianReport report;
  report.gaussian = trace.gaussians[slot];
  report.depth = trace.depths[slot];
  report.opacity = std::min(trace.splats[slot].opacity, 1.0f);  // a solid ellipse has more
  report.color = trace.splats[slot].color;
  report.footprint = trace.footprints[slot];
  report.visible = report.footprint.gamma > 0;
  report.anisotropy = anisotropy_of(report.footprint);
  report.tilt = tilt_of(report.footprint);
  if (report.visible)
    report.half_axes = glm::vec2(glm::sqrt(static_cast<double>(report.footprint.gamma) *
                                           eigenvalues(report.footprint.covariance)));
  add_boxes(report);
  for (CullMode mode = 1; mode <= culler_count(); ++mode)
    report.modes.push_back(mode_tiles(mode, report.footprint, grid));
  return report;
}

}  // namespace qs
