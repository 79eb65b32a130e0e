// SPDX-License-Identifier: MIT
#include "app/train/initial.h"

#include <algorithm>
#include <cmath>

#include "app/train/nearest.h"
#include "raster/kernel/constants.h"
#include "raster/kernel/random.h"

namespace qs::train {

Parameters gaussians_at(const std::vector<ScenePoint>& points, const InitialGaussians& initial,
                        ThreadPool& pool) {
  constexpr double kLeastDistance2 = 1e-7;
  Parameters gaussians;
  gaussians.sh_degree = initial.sh_degree;
  gaussians.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    gaussians.means[i] = glm::vec3(points[i].position);
  const std::vector<double> distances2 = neighbour_distances2(gaussians.means, pool);
  const double logit = std::log(initial.opacity / (1 - initial.opacity));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double scale = initial.scale * std::sqrt(std::max(kLeastDistance2, distances2[i]));
    gaussians.log_scales[i] = glm::vec3(static_cast<float>(std::log(scale)));
    gaussians.rotations[i] = glm::quat(1, 0, 0, 0);
    gaussians.opacity_logits[i] = static_cast<float>(logit);
    gaussians.sh[i * gaussians.sh_stride()] = (points[i].color - 0.5f) / static_cast<float>(kSh0);
  }
  return gaussians;
}

std::vector<ScenePoint> random_points(const DataSet& data, std::size_t count, std::uint64_t seed) {
  glm::dvec3 low = data.training.front().camera.position(), high = low;
  for (const PhotographView& view : data.training) {
    low = glm::min(low, view.camera.position());
    high = glm::max(high, view.camera.position());
  }
  glm::dvec3 middle = 0.5 * (low + high);
  // Cameras in a plane or a point still need a box with a volume.
  glm::dvec3 half = glm::max(1.5 * (high - low), glm::dvec3(data.extent()));
  if (data.blender) {
    middle = glm::dvec3(0);
    half = glm::dvec3(1.3);
  }
  const Random random = Random::of(seed, RandomUse::start, 0);
  std::vector<ScenePoint> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int axis = static_cast<int>(k);
      points[i].position[axis] = middle[axis] + half[axis] * (2 * random.uniform(3 * i + k) - 1);
    }
    points[i].color = glm::vec3(0.5f);
  }
  return points;
}

}  // namespace qs::train
