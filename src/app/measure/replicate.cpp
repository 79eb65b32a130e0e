// SPDX-License-Identifier: MIT
#include "app/measure/replicate.h"

#include <algorithm>
#include <cmath>

#include "app/framing/scene_box.h"
#include "base/fail.h"

namespace qs {

GaussianCloud replicate(const GaussianCloud& cloud, glm::ivec2 copies, glm::dvec3 up) {
  constexpr double kGap = 1.1;
  const std::size_t count = static_cast<std::size_t>(copies.x) * static_cast<std::size_t>(copies.y);
  if (cloud.size() > 0x7fffffffu / count)
    fail(ErrorKind::device, "--replicate: {} copies of {} Gaussians are more than 2^31", count,
         cloud.size());
  int vertical = std::abs(up.y) > std::abs(up.x) ? 1 : 0;
  if (std::abs(up.z) > std::abs(up[vertical])) vertical = 2;
  const glm::vec3 step = static_cast<float>(kGap) * core_box(cloud).size();
  GaussianCloud result;
  result.resize(cloud.size() * count, cloud.sh_degree);
  result.antialiased = cloud.antialiased;
  result.origin = cloud.origin;
  for (std::size_t copy = 0; copy < count; ++copy) {
    const std::size_t column = copy % static_cast<std::size_t>(copies.x);
    const std::size_t row = copy / static_cast<std::size_t>(copies.x);
    glm::vec3 offset{0.0f};
    offset[(vertical + 1) % 3] = static_cast<float>(column) * step[(vertical + 1) % 3];
    offset[(vertical + 2) % 3] = static_cast<float>(row) * step[(vertical + 2) % 3];
    const auto place = [copy](const auto& from, auto& to) {
      std::ranges::copy(from, to.begin() + static_cast<std::ptrdiff_t>(copy * from.size()));
    };
    place(cloud.log_scales, result.log_scales);
    place(cloud.rotations, result.rotations);
    place(cloud.opacity_logits, result.opacity_logits);
    place(cloud.sh, result.sh);
    std::ranges::transform(
        cloud.positions,
        result.positions.begin() + static_cast<std::ptrdiff_t>(copy * cloud.size()),
        [offset](glm::vec3 position) { return position + offset; });
  }
  return result;
}

}  // namespace qs
