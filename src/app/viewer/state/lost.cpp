// SPDX-License-Identifier: MIT
#include "app/viewer/state/lost.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace qs {
namespace {

constexpr double kFewGaussians = 0.01;  ///< of the scene's
constexpr double kFewPairs = 2;         ///< per tile, in the mean
constexpr double kMargin = 0.05;        ///< from the picture's edge to the tip, of its shorter side

/// The direction of a point in view space, right and down. A camera cannot turn over its poles, so
/// a point behind it has the angles of the turns to the side, which come first, and up or down.
glm::dvec2 aside_of(glm::dvec3 at, double near_depth) {
  if (at.z > near_depth) return glm::dvec2(at) / at.z;
  return {std::atan2(at.x, at.z), std::atan2(at.y, std::hypot(at.x, at.z))};
}

double tiles_of(const ShownFrame& shown) {
  const double side = kTileSize * shown.divisor;
  return std::ceil(shown.camera.width / side) * std::ceil(shown.camera.height / side);
}

}  // namespace

bool is_lost(const Viewer& v) {
  const RenderStats& stats = v.shown.stats;
  if (!v.scene || v.zoom.running || v.shown.version != v.version || !v.still()) return false;
  if (v.playback.running || stats.gaussians == 0 || stats.is_occluded) return false;
  return stats.visible < kFewGaussians * stats.gaussians &&
         static_cast<double>(stats.tile_pairs) <= kFewPairs * tiles_of(v.shown);
}

std::optional<WayToSubject> way_to_subject(const Viewer& v) {
  if (!is_lost(v)) return std::nullopt;
  const Camera& camera = v.camera;
  const glm::dvec3 at = camera.view_from_world * glm::dvec4(v.scene->framing.target, 1);
  const glm::dvec2 size(camera.width, camera.height);
  const glm::dvec2 middle = 0.5 * (size - 1.0);
  const glm::dvec2 half = 0.5 * size - kMargin * std::min(size.x, size.y);
  const glm::dvec2 aside = aside_of(at, camera.near_depth);
  WayToSubject way;
  if (glm::length(aside) > 1e-9) way.direction = glm::normalize(aside);  // else right in front
  if (at.z > camera.near_depth) {
    const glm::dvec2 seen = aside * camera.focal_px + camera.center_px - middle;
    if (std::abs(seen.x) < half.x && std::abs(seen.y) < half.y) {
      way.tip = middle + seen;
      return way;
    }
  }
  const glm::dvec2 steps = half / glm::max(glm::abs(way.direction), 1e-12);
  way.tip = middle + std::min(steps.x, steps.y) * way.direction;
  return way;
}

}  // namespace qs
