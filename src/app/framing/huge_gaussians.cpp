// SPDX-License-Identifier: MIT
#include "app/framing/huge_gaussians.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "app/framing/scene_box.h"
#include "base/text.h"
#include "raster/scene/cloud_order.h"

namespace qs {
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

std::string huge_text(std::size_t count) {
  return count == 1 ? "1 Gaussian is larger than the scene"
                    : fmt::format("{} Gaussians are larger than the scene", grouped(count));
}

}  // namespace qs
