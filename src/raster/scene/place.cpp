// SPDX-License-Identifier: MIT
#include "raster/scene/place.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "base/list_of.h"
#include "base/rank.h"

namespace qs {
namespace {

constexpr std::size_t kMostLookedAt = 4096;
constexpr double kFar = 1000, kFarInSizes = 16;
constexpr double kFarthest = 1e9;  // no place on Earth is farther away, in metres

}  // namespace

glm::dvec3 origin_of(std::size_t count, const std::function<glm::dvec3(std::size_t i)>& position) {
  const std::size_t step = 1 + count / kMostLookedAt;
  glm::dvec3 middle(0);
  double size = 0, distance = 0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (std::size_t i = 0; i < count; i += step)
      if (const double at = position(i)[axis]; std::isfinite(at)) values.push_back(at);
    if (values.empty()) return glm::dvec3(0);
    middle[axis] = quantile(values, 0.5);
    size = std::max(size, quantile(values, 0.95) - quantile(values, 0.05));
    distance = std::max(distance, std::abs(middle[axis]));
  }
  if (!(distance > kFar && distance > kFarInSizes * size && distance < kFarthest))
    return glm::dvec3(0);
  const double unit = std::pow(10.0, std::ceil(std::log10(std::max(size, 1.0))));
  return glm::round(middle / unit) * unit;
}

void place(GaussianCloud& cloud, const glm::dvec3& origin) {
  if (origin == cloud.origin) return;
  const glm::dvec3 move = cloud.origin - origin;
  for (glm::vec3& position : cloud.positions) position = glm::vec3(glm::dvec3(position) + move);
  cloud.origin = origin;
}

void move_near_origin(GaussianCloud& cloud) {
  place(cloud, cloud.origin + origin_of(cloud.size(), [&](std::size_t i) {
                 return glm::dvec3(cloud.positions[i]);
               }));
}

std::string format_origin(const glm::dvec3& origin) {
  return fmt::format("{} {} {}", origin.x, origin.y, origin.z);
}

std::optional<glm::dvec3> parse_origin(std::string_view text) {
  std::istringstream words{std::string(text)};
  glm::dvec3 origin(0);
  std::string rest;
  if (!(words >> origin.x >> origin.y >> origin.z) || words >> rest) return {};
  if (!glm::all(glm::lessThan(glm::abs(origin), glm::dvec3(kFarthest)))) return {};
  return origin;
}

std::vector<std::size_t> outliers(const std::vector<Camera>& cameras) {
  constexpr double kFarInMedians = 10;
  if (cameras.empty()) return {};
  glm::dvec3 middle;
  for (int axis = 0; axis < 3; ++axis)
    middle[axis] = upper_median(
        list_of<double>(cameras, [&](const Camera& camera) { return camera.position()[axis]; }));
  const auto distances = list_of<double>(
      cameras, [&](const Camera& camera) { return glm::distance(camera.position(), middle); });
  const double far = kFarInMedians * upper_median(distances);
  std::vector<std::size_t> found;
  for (std::size_t i = 0; far > 0 && i < cameras.size(); ++i)
    if (distances[i] > far) found.push_back(i);
  // More than a few are no mistake but a second place.
  return found.size() > 1 && 4 * found.size() > cameras.size() ? std::vector<std::size_t>() : found;
}

std::vector<Camera> without_outliers(const std::vector<Camera>& cameras) {
  std::vector<Camera> kept = cameras;
  const std::vector<std::size_t> far = outliers(cameras);
  for (auto i = far.rbegin(); i != far.rend(); ++i)
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(*i));
  return kept;
}

bool sees_any(const Camera& camera, std::size_t count,
              const std::function<glm::dvec4(std::size_t i)>& ball) {
  const std::size_t step = 1 + count / kMostLookedAt;
  const glm::dvec2 sides(camera.width, camera.height);
  for (std::size_t i = 0; i < count; i += step) {
    const glm::dvec4 world = ball(i);
    const glm::dvec3 at = camera.view_from_world * glm::dvec4(glm::dvec3(world), 1);
    const glm::dvec2 pixel = camera.focal_px * glm::dvec2(at) / at.z + camera.center_px;
    const glm::dvec2 reach = world.w * camera.focal_px / at.z;
    if (at.z > camera.near_depth && glm::all(glm::greaterThan(pixel + reach, glm::dvec2(-0.5))) &&
        glm::all(glm::lessThan(pixel - reach, sides - 0.5)))
      return true;
  }
  return false;
}

}  // namespace qs
