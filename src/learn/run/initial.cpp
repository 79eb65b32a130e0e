// SPDX-License-Identifier: MIT
#include "learn/run/initial.h"

#include <algorithm>
#include <cmath>

#include "learn/step/nearest.h"
#include "raster/kernel/constants.h"
#include "raster/kernel/project.h"
#include "raster/kernel/random.h"
#include "raster/scene/place.h"

namespace qs::train {
namespace {

struct CellBox {
  glm::dvec3 low, size;
};

// The cameras' bounding box enlarged 3 times around its middle.
CellBox box_around_cameras(const DataSet& data) {
  std::vector<Camera> cameras = data.training_cameras();
  if (!data.published_extent) cameras = without_outliers(cameras);
  glm::dvec3 low = cameras.front().position(), high = low;
  for (const Camera& camera : cameras) {
    low = glm::min(low, camera.position());
    high = glm::max(high, camera.position());
  }
  // Cameras in a plane or a point still need a box with a volume.
  const glm::dvec3 half = glm::max(1.5 * (high - low), glm::dvec3(data.extent()));
  return {0.5 * (low + high) - half, 2.0 * half};
}

constexpr int kCells = 64;  // cells of the grid along an axis of the box

// The cell's low corner, in cells from the low corner of the box.
glm::dvec3 corner_of(std::size_t cell) {
  return {cell % kCells, cell / kCells % kCells, cell / (kCells * kCells)};
}

// The position of `place`, which has the units of corner_of().
glm::dvec3 position_in(const CellBox& box, glm::dvec3 place) {
  return box.low + box.size * place / double{kCells};
}

// The cells that many pictures show: at least half as many as the largest number of pictures that
// show the same cell. A picture shows a cell if it shows the cell's middle. If cameras circle a
// subject, most pictures show the subject and few show a camera.
std::vector<std::size_t> cells_in_many_pictures(const DataSet& data, const CellBox& box) {
  constexpr std::size_t kMostCameras = 200;
  const std::size_t stride = 1 + (data.training.size() - 1) / kMostCameras;
  std::vector<int> pictures(std::size_t{kCells} * kCells * kCells, 0);
  for (std::size_t i = 0; i < data.training.size(); i += stride) {
    const Camera& camera = data.training[i].camera;
    const View<double> view = make_view<double>(camera);
    for (std::size_t cell = 0; cell < pictures.size(); ++cell) {
      const glm::dvec3 at = to_view(view, position_in(box, corner_of(cell) + 0.5));
      if (at.z <= view.near_depth) continue;
      const glm::dvec2 pixel = to_pixel(view, at);
      if (pixel.x >= -0.5 && pixel.y >= -0.5 && pixel.x <= camera.width - 0.5 &&
          pixel.y <= camera.height - 0.5)
        ++pictures[cell];
    }
  }
  const int most = *std::ranges::max_element(pictures);
  std::vector<std::size_t> cells;
  for (std::size_t cell = 0; cell < pictures.size(); ++cell)
    if (2 * pictures[cell] >= most) cells.push_back(cell);
  return cells;
}

}  // namespace

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

Parameters with_masks(Parameters gaussians) {
  gaussians.has_masks = true;
  gaussians.mask_logits.assign(gaussians.size(), kFirstMaskLogit);
  return gaussians;
}

std::vector<ScenePoint> random_points(const DataSet& data, std::size_t count, std::uint64_t seed) {
  const Random random = Random::of(seed, RandomUse::start, 0);
  const auto uniform = [&](std::size_t i) {
    return glm::dvec3(random.uniform(4 * i), random.uniform(4 * i + 1), random.uniform(4 * i + 2));
  };
  std::vector<ScenePoint> points(count);
  for (ScenePoint& point : points) point.color = glm::vec3(0.5f);
  if (data.blender) {
    for (std::size_t i = 0; i < count; ++i) points[i].position = 1.3 * (2.0 * uniform(i) - 1.0);
    return points;
  }
  const CellBox box = box_around_cameras(data);
  const std::vector<std::size_t> cells = cells_in_many_pictures(data, box);
  for (std::size_t i = 0; i < count; ++i) {
    const auto drawn =
        static_cast<std::size_t>(random.uniform(4 * i + 3) * static_cast<double>(cells.size()));
    points[i].position =
        position_in(box, (corner_of(cells[std::min(drawn, cells.size() - 1)])) + uniform(i));
  }
  return points;
}

}  // namespace qs::train
