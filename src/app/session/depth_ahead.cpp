// SPDX-License-Identifier: MIT
#include "app/session/depth_ahead.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/gtc/constants.hpp>

namespace qs {
namespace {

// Of the picture: a single near Gaussian must not decide.
constexpr double kMostShare = 0.1;

}  // namespace

std::vector<Landmark> landmarks_of(const GaussianCloud& cloud, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, (cloud.size() + most - 1) / most);
  std::vector<Landmark> landmarks;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    const glm::vec3 position = cloud.positions[i], size = cloud.log_scales[i];
    // The product of the two larger standard deviations: the broadest side. The smallest may be 0.
    const float largest = std::max({size.x, size.y, size.z});
    const float middle =
        std::max(std::min(size.x, size.y), std::min(std::max(size.x, size.y), size.z));
    const float broadest = std::exp(largest + middle);
    const float opacity = 1 / (1 + std::exp(-cloud.opacity_logits[i]));
    const float area = glm::two_pi<float>() * opacity * broadest * static_cast<float>(step);
    if (std::isfinite(position.x + position.y + position.z) && std::isfinite(area) && area > 0)
      landmarks.push_back({position, area});
  }
  return landmarks;
}

std::optional<double> depth_ahead(const Camera& camera, std::span<const Landmark> landmarks) {
  const double pixels = static_cast<double>(camera.width) * camera.height;
  std::vector<std::pair<double, double>> shares;  // depths, and areas in the picture over its own
  for (const Landmark& landmark : landmarks) {
    const glm::dvec3 at = camera.view_from_world * glm::dvec4(glm::dvec3(landmark.position), 1);
    if (!(at.z > camera.near_depth)) continue;
    const glm::dvec2 pixel = glm::dvec2(at) / at.z * camera.focal_px + camera.center_px;
    if (!(pixel.x >= 0 && pixel.y >= 0 && pixel.x < camera.width && pixel.y < camera.height))
      continue;
    const glm::dvec2 scale = camera.focal_px / at.z;
    const double share = static_cast<double>(landmark.area) * scale.x * scale.y / pixels;
    shares.emplace_back(at.z, std::min(share, kMostShare));
  }
  if (shares.empty()) return std::nullopt;
  std::sort(shares.begin(), shares.end());
  double total = 0;
  for (const auto& [depth, share] : shares) total += share;
  const double covered = 1 - std::exp(-total);
  double in_front = 0;
  for (const auto& [depth, share] : shares) {
    in_front += share;
    if (1 - std::exp(-in_front) >= 0.5 * covered) return depth;
  }
  return shares.back().first;
}

}  // namespace qs
