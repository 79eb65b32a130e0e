// SPDX-License-Identifier: MIT
#include "app/framing/scene_box.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace qs {

SceneBox scene_box(const GaussianCloud& cloud, double low, double high) {
  SceneBox result;
  if (cloud.empty()) return result;
  std::vector<float> values(cloud.size());
  const auto quantile = [&values](double fraction) {
    const auto nth = std::lround(fraction * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + nth, values.end());
    return values[static_cast<std::size_t>(nth)];
  };
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(cloud.positions.begin(), cloud.positions.end(), values.begin(),
                   [axis](const glm::vec3& position) { return position[axis]; });
    result.low[axis] = quantile(low);
    result.high[axis] = quantile(high);
  }
  return result;
}

}  // namespace qs
