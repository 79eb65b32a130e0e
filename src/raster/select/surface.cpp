// SPDX-License-Identifier: MIT
#include "raster/select/surface.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "raster/api/trace.h"
#include "raster/kernel/composite.h"

namespace qs {

OnRay on_ray(const GaussianCloud& cloud, std::size_t i, glm::dvec3 eye, glm::dvec3 direction) {
  const glm::dvec3 offset = glm::dvec3(cloud.positions[i]) - eye;
  const glm::dquat into = glm::conjugate(glm::normalize(glm::dquat(cloud.rotations[i])));
  const glm::dvec3 ray = into * direction, centre = into * offset;
  const glm::dvec3 log_scale(cloud.log_scales[i]);
  const double thinnest = std::min({log_scale.x, log_scale.y, log_scale.z});
  double sum = 0, weights = 0;
  for (int axis = 0; axis < 3; ++axis) {
    // The inverse variance times the least variance; an axis without extent counts alone.
    const double weight =
        log_scale[axis] == thinnest ? 1 : std::exp(2 * (thinnest - log_scale[axis]));
    sum += weight * ray[axis] * centre[axis];
    weights += weight * ray[axis] * ray[axis];
  }
  if (!(weights > 0)) return {std::max(glm::dot(offset, direction), 0.0), 0};
  return {std::max(sum / weights, 0.0), std::exp(thinnest) / std::sqrt(weights)};
}

std::optional<SurfacePoint> surface_at(const Frame& frame, const GaussianCloud& cloud,
                                       const Camera& camera, glm::ivec2 pixel) {
  if (pixel.x < 0 || pixel.y < 0 || pixel.x >= camera.width || pixel.y >= camera.height) return {};
  const auto [eye, direction, across] = sight_of(camera.placed(cloud.origin), pixel);
  SurfacePoint point;
  point.direction = direction;

  constexpr double kLeft[] = {0.75, 0.5, 0.25};  // of the light
  std::optional<OnRay> at[3];
  float transmittance = 1;
  std::optional<std::uint32_t> last;
  for (const std::uint32_t gaussian : list_of(frame.trace, frame.grid.tile_of(pixel.x, pixel.y))) {
    float alpha = 0;
    const Step step =
        composite(frame.trace.splats[*slot_of(frame.trace, gaussian)], static_cast<float>(pixel.x),
                  static_cast<float>(pixel.y), transmittance, alpha);
    if (step == Step::stops || at[2]) break;
    if (step == Step::skips) continue;
    last = gaussian;
    for (int share = 0; share < 3; ++share)
      if (!at[share] && double{transmittance} <= kLeft[share]) {
        if (share == 1) point.gaussian = gaussian;
        at[share] = on_ray(cloud, gaussian, eye, point.direction);
      }
  }
  if (!at[1]) return {};
  if (!at[2]) at[2] = on_ray(cloud, *last, eye, point.direction);
  point.distance = at[1]->at;
  point.along = std::hypot((at[2]->at - at[0]->at) / 2, at[1]->sigma);
  point.across = across * point.distance;
  point.position = eye + point.distance * point.direction;
  return point;
}

Sight sight_of(const Camera& camera, glm::dvec2 pixel) {
  const glm::dvec2 slope = (pixel - camera.center_px) / camera.focal_px;
  const glm::dmat3 world_from_view = glm::inverse(glm::dmat3(camera.view_from_world));
  return {camera.position(), glm::normalize(world_from_view * glm::dvec3(slope, 1)),
          1 / (std::min(camera.focal_px.x, camera.focal_px.y) * std::sqrt(12.0))};
}

Sight sight_of(const SurfacePoint& point) {
  return {point.position - point.distance * point.direction, point.direction,
          point.across / point.distance};
}

std::optional<Crossing> crossing(const Sight& a, const Sight& b) {
  constexpr double kParallel = 1e-9;
  const double cosine = glm::dot(a.direction, b.direction), sine2 = 1 - cosine * cosine;
  const glm::dvec3 between = b.eye - a.eye;
  const double to_a = glm::dot(between, a.direction), to_b = glm::dot(between, b.direction);
  const double at_a = (to_a - cosine * to_b) / sine2, at_b = (cosine * to_a - to_b) / sine2;
  if (!(sine2 > kParallel && at_a > 0 && at_b > 0)) return {};
  const glm::dvec3 on_a = a.eye + at_a * a.direction, on_b = b.eye + at_b * b.direction;
  Crossing found;
  found.gap = glm::distance(on_a, on_b);
  // Each line fixes a place across itself, both as the worse one does: the inverse variances add up
  // to 1 - cosine along the mean of the directions, and to 1 + cosine across it in their plane.
  const double across = std::hypot(std::max(at_a * a.across, at_b * b.across), found.gap / 2);
  const double least = across / std::sqrt(1 - std::abs(cosine));
  found.point = {.position = 0.5 * (on_a + on_b),
                 .direction = glm::normalize(a.direction + b.direction),
                 .distance = at_a,
                 .along = least,
                 .across = cosine > 0 ? across / std::sqrt(1 + cosine) : least};
  return found;
}

MeasuredLength length_between(const SurfacePoint& a, const SurfacePoint& b) {
  const glm::dvec3 line = b.position - a.position;
  const double length = glm::length(line);
  const glm::dvec3 unit = length > 0 ? line / length : a.direction;
  double variance = 0;
  for (const SurfacePoint* point : {&a, &b}) {
    const double cosine = glm::dot(point->direction, unit);
    variance += point->along * point->along * cosine * cosine +
                point->across * point->across * (1 - cosine * cosine);
  }
  return {length, std::sqrt(std::max(variance, 0.0))};
}

}  // namespace qs
