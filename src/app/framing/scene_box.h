// SPDX-License-Identifier: MIT
//
// The extents of a scene: the box of all centres, and the core box without outliers.
#pragma once

#include <algorithm>
#include <vector>

#include <glm/vec3.hpp>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// The vertical field of view of the cameras that framings make.
inline constexpr double kVerticalFov = glm::radians(60.0);

inline float largest_of(const glm::vec3& v) { return std::max({v.x, v.y, v.z}); }

/// The upper one of two medians. `values` is not empty.
template <class T>
T upper_median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// An axis-aligned box, world units; low <= high.
struct SceneBox {
  glm::vec3 low{0.0f}, high{0.0f};
  glm::vec3 center() const { return 0.5f * (low + high); }
  glm::vec3 size() const { return high - low; }
};

/// Per axis, from the `low` to the `high` quantile (0..1) of the centres. (0, 1) covers all
/// centres. An empty cloud gives a box of size 0 at the origin.
SceneBox scene_box(const GaussianCloud& cloud, double low = 0, double high = 1);

/// The box without the outermost 5 % of the centres at each end of each axis. It determines the
/// view and the speed of movements.
inline SceneBox core_box(const GaussianCloud& cloud) { return scene_box(cloud, 0.05, 0.95); }

}  // namespace qs
