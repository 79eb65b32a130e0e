// SPDX-License-Identifier: MIT
#include "app/framing/scene_box.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "base/text.h"
#include "io/scene/reader.h"
#include "raster/scene/cloud_order.h"

namespace qs {
namespace {

constexpr double kMargin = 1.15;  // shows some surroundings of the core box
constexpr double kElevation = glm::radians(15.0);

// The horizontal viewing direction: z, the forward axis of RDF, or y if z points up.
glm::dvec3 horizontal_forward(glm::dvec3 up) {
  return up.z == 0 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
}

}  // namespace

SceneBox scene_box(const GaussianCloud& cloud, double low, double high) {
  SceneBox result;
  if (cloud.empty()) return result;
  std::vector<float> values(cloud.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(cloud.positions, values.begin(),
                           [axis](glm::vec3 p) { return p[axis]; });
    result.low[axis] = quantile(values, low);
    result.high[axis] = quantile(values, high);
  }
  return result;
}

Camera frame_box(const SceneBox& box, float smallest, glm::dvec3 up, int width, int height) {
  const glm::dvec3 size(box.size());
  const double radius = kMargin * std::max<double>(0.5 * glm::length(size), smallest);
  const double slope =
      std::tan(0.5 * kVerticalFov) * std::min(1.0, static_cast<double>(width) / height);
  const double distance = radius / std::sin(std::atan(slope));
  const glm::dvec3 center(box.center());
  const glm::dvec3 toward_eye =
      std::sin(kElevation) * up - std::cos(kElevation) * horizontal_forward(up);
  Camera camera = look_at(center + distance * toward_eye, center, up, kVerticalFov, width, height);
  camera.near_depth = std::min(0.2, 0.01 * std::max({size.x, size.y, size.z, 2 * radius}));
  return camera;
}

float smallest_framing(const GaussianCloud& cloud) {
  std::vector<float> logs(cloud.size());
  std::transform(cloud.log_scales.begin(), cloud.log_scales.end(), logs.begin(), largest_of);
  const float largest = logs.empty() ? 0 : std::exp(upper_median(std::move(logs)));
  return largest > 0 && std::isfinite(largest) ? 3 * largest : 1e-3f;
}

Camera frame_cloud(const GaussianCloud& cloud, glm::dvec3 up, int width, int height) {
  return frame_box(core_box(cloud), smallest_framing(cloud), up, width, height);
}

float scene_length(const SceneBox& core, float smallest) {
  const float diagonal = glm::length(core.size());
  return std::max(std::isfinite(diagonal) ? diagonal : 0.0f, smallest);
}

float scene_length(const GaussianCloud& cloud) {
  return scene_length(core_box(cloud), smallest_framing(cloud));
}

std::size_t count_huge(const GaussianCloud& cloud, float length) {
  const auto is_huge = [most = std::log(length)](float scale) { return scale > most; };
  return static_cast<std::size_t>(std::ranges::count_if(cloud.log_scales, is_huge, largest_of));
}

std::size_t drop_huge(GaussianCloud& cloud) {
  const float most = std::log(scene_length(cloud));
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (!(largest_of(cloud.log_scales[i]) > most)) kept.push_back(static_cast<std::uint32_t>(i));
  const std::size_t dropped = cloud.size() - kept.size();
  if (dropped > 0) cloud = select(cloud, kept);
  return dropped;
}

std::size_t drop_huge(Scene& scene) {
  Edits edits = scene.edits;
  const float most = std::log(scene_length(scene.cloud));
  edits.remove(scene.cloud.size(),
               [&](std::size_t i) { return largest_of(scene.cloud.log_scales[i]) > most; });
  const std::size_t dropped = drop_huge(scene.cloud);
  if (dropped > 0) scene.edits = std::move(edits);
  return dropped;
}

std::string huge_text(std::size_t count) {
  return count == 1 ? "1 Gaussian is larger than the scene"
                    : fmt::format("{} Gaussians are larger than the scene", grouped(count));
}

}  // namespace qs
