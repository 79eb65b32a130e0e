// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "io/cloud/cloud_memory.h"
#include "io/scene/gltf/gltf_file.h"
#include "raster/kernel/constants.h"

namespace qs {

void fill_gaussian(const GltfSplats& splats, std::uint64_t from, GaussianCloud& cloud,
                   std::size_t to, GltfClamped& clamped) {
  glm::vec3* const sh = sh_of(cloud, to);
  std::fill_n(sh, sh_count(cloud), glm::vec3(0));
  if (splats.cloud) return copy_gaussian(*splats.cloud, from, cloud, to);
  const auto vector = [from](const GltfNumbers& numbers) {
    return glm::vec3(numbers(from, 0), numbers(from, 1), numbers(from, 2));
  };
  cloud.positions[to] = vector(splats.positions);
  const GltfNumbers& q = splats.rotations;
  cloud.rotations[to] = glm::quat(q(from, 3), q(from, 0), q(from, 1), q(from, 2));
  glm::vec3 scale = vector(splats.scales);
  if (!splats.scales_are_logarithms) {
    if (scale.x < 0 || scale.y < 0 || scale.z < 0) ++clamped.scales;
    scale = glm::log(glm::max(scale, glm::vec3(0)));
  }
  cloud.log_scales[to] = scale;
  const bool has_colors = splats.colors.count > 0;
  const double opacity = has_colors ? splats.colors(from, 3) : splats.opacities(from, 0);
  if (opacity < 0 || opacity > 1) ++clamped.opacities;
  const double inside = opacity < 0 ? 0 : opacity > 1 ? 1 : opacity;  // NaN stays
  cloud.opacity_logits[to] = static_cast<float>(std::log(inside / (1 - inside)));
  if (has_colors) sh[0] = (vector(splats.colors) - 0.5f) / static_cast<float>(kSh0);
  const std::size_t first = has_colors ? 1 : 0;
  for (std::size_t k = 0; k < splats.sh.size(); ++k) sh[first + k] = vector(splats.sh[k]);
}

// In the draft most scales of trained Gaussians are negative, because they are logarithms of
// numbers below 1. A linear writer produces only occasional negative values.
bool are_logarithms(const GltfNumbers& scales) {
  std::uint64_t negative = 0;
  for (std::uint64_t i = 0; i < scales.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) negative += scales(i, axis) < 0 ? 1 : 0;
  }
  return negative > scales.count * 3 / 2;
}

}  // namespace qs
