// SPDX-License-Identifier: MIT
#include "raster/pages/surfaces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace qs {

LodSurfaces::LodSurfaces(const Camera& camera, std::vector<float> depths, float margin)
    : turn_(camera.view_from_world),
      eye_(camera.position()),
      focal_(camera.focal_px),
      center_(camera.center_px),
      width_(camera.width),
      height_(camera.height),
      margin_(margin),
      near_depth_(static_cast<float>(camera.near_depth)),
      depths_(std::move(depths)) {
  std::ranges::replace(depths_, 0.0f, std::numeric_limits<float>::infinity());
  std::vector<float> sorted = depths_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::ranges::nth_element(sorted, middle);
  distance_ = *middle;
}

float LodSurfaces::share_seen(const glm::vec3& center, float radius) const {
  constexpr int kMost = 8;  // pixels on a side
  const glm::vec3 at = turn_ * glm::vec3(glm::dvec3(center) - eye_);
  const float nearest = at.z - radius;
  if (!(nearest > near_depth_)) return 1;
  const glm::vec2 middle = focal_ * glm::vec2(at) / at.z + center_,
                  reach = focal_ * radius / nearest + margin_;
  const glm::vec2 size(width_, height_);
  const glm::ivec2 low = glm::clamp(middle - reach, glm::vec2(0), size);
  const glm::ivec2 high = glm::clamp(middle + reach + 1.0f, glm::vec2(0), size);
  if (low.x >= high.x || low.y >= high.y) return 1;
  const glm::ivec2 step = glm::max((high - low) / kMost, 1);
  int seen = 0, all = 0;
  for (int y = low.y; y < high.y; y += step.y) {
    const float* const row =
        depths_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
    for (int x = low.x; x < high.x; x += step.x) {
      seen += nearest <= row[x] ? 1 : 0;
      ++all;
    }
  }
  return std::max(kLeastSeen, static_cast<float>(seen) / static_cast<float>(all));
}

}  // namespace qs
