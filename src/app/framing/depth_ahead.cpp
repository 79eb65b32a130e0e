// SPDX-License-Identifier: MIT
#include "app/framing/depth_ahead.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <glm/gtc/constants.hpp>

#include "app/framing/scene_box.h"

namespace qs {
namespace {

constexpr int kRegions = 8;  // regions of the picture along each side

struct Share {
  double depth, cover;  // integral of the opacity over a cell's area
};

// Half of the light of a cell comes from Gaussians nearer than this depth. The shares are spread
// evenly over the cell, so transmittance falls exponentially (Beer and Lambert).
double depth_of_cell(std::vector<Share>& shares) {
  std::ranges::sort(shares, {}, &Share::depth);
  double total = 0, in_front = 0;
  for (const Share& share : shares) total += share.cover;
  const double half = -std::log(0.5 * (1 + std::exp(-total)));  // optical depth of half the light
  for (const Share& share : shares) {
    in_front += share.cover;
    if (in_front >= half) return share.depth;
  }
  return shares.back().depth;
}

}  // namespace

std::vector<Landmark> landmarks_of(const GaussianCloud& cloud, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, (cloud.size() + most - 1) / most);
  std::vector<Landmark> landmarks;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    const glm::vec3 position = cloud.positions[i], size = cloud.log_scales[i];
    // The product of the two larger standard deviations: the broadest side. The smallest may be 0.
    const float largest = largest_of(size);
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
  const glm::dvec2 cell_px =
      glm::dvec2(camera.width, camera.height) / static_cast<double>(kRegions);
  std::array<std::vector<Share>, kRegions * kRegions> cells;
  for (const Landmark& landmark : landmarks) {
    const glm::dvec3 at = camera.view_from_world * glm::dvec4(glm::dvec3(landmark.position), 1);
    if (!(at.z > camera.near_depth)) continue;
    const glm::dvec2 scale = camera.focal_px / at.z;
    const glm::dvec2 cell = (glm::dvec2(at) * scale + camera.center_px) / cell_px;
    if (!(cell.x >= 0 && cell.y >= 0 && cell.x < kRegions && cell.y < kRegions)) continue;
    const double cover = static_cast<double>(landmark.area) * scale.x * scale.y;
    cells[static_cast<std::size_t>(static_cast<int>(cell.y) * kRegions + static_cast<int>(cell.x))]
        .push_back({at.z, std::min(cover / (cell_px.x * cell_px.y), 1.0)});
  }
  std::vector<double> depths;
  for (std::vector<Share>& shares : cells) {
    if (!shares.empty()) depths.push_back(depth_of_cell(shares));
  }
  if (depths.empty()) return std::nullopt;
  return upper_median(std::move(depths));
}

}  // namespace qs
