// SPDX-License-Identifier: MIT
#include "learn/step/nearest.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <limits>

#include <glm/vec3.hpp>
#include <nanoflann.hpp>

#include "raster/scene/gaussian_cloud.h"

namespace qs::train {
namespace {

constexpr std::size_t kNeighbours = 3;

// The points in the interface that nanoflann reads.
struct Points {
  const std::vector<glm::vec3>& positions;

  std::size_t kdtree_get_point_count() const { return positions.size(); }
  double kdtree_get_pt(std::size_t point, std::size_t axis) const {
    return double{positions[point][static_cast<int>(axis)]};
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>,
                                                 Points, 3, std::uint32_t>;

// The smallest squared distances so far. The tree skips farther cells and points.
struct Nearest : nanoflann::KNNResultSet<double, std::uint32_t> {
  using KNNResultSet::KNNResultSet;
  // The margin keeps cells whose distance the tree rounded up.
  double worstDist() const { return KNNResultSet::worstDist() * (1 + 1e-12); }
  // False ends the search: else it would go through all copies of a point.
  bool addPoint(double distance2, std::uint32_t point) {
    KNNResultSet::addPoint(distance2, point);
    return worstDist() > 0;
  }
};

// neighbour_distances2() of points that are all finite.
std::vector<double> distances2_of_finite(const std::vector<glm::vec3>& points, ThreadPool& pool) {
  std::vector<double> means(points.size(), 0);
  if (points.size() < 2) return means;
  const Points source{points};
  const Tree tree(3, source);
  const std::size_t neighbours = std::min(kNeighbours, points.size() - 1);
  pool.for_each(points.size(), 1024, [&](std::size_t i) {
    std::array<std::uint32_t, 1 + kNeighbours> indices;
    std::array<double, 1 + kNeighbours> distances2;  // ascending; the first 0 is the point's own
    Nearest nearest(1 + neighbours);
    nearest.init(indices.data(), distances2.data());
    const glm::dvec3 point(points[i]);
    tree.findNeighbors(nearest, &point.x, {});
    for (std::size_t k = 1; k <= neighbours; ++k)
      means[i] += distances2[k] / static_cast<double>(neighbours);
  });
  return means;
}

}  // namespace

std::vector<double> neighbour_distances2(const std::vector<glm::vec3>& points, ThreadPool& pool) {
  if (std::ranges::all_of(points, is_finite)) return distances2_of_finite(points, pool);
  std::vector<glm::vec3> finite;
  std::ranges::copy_if(points, std::back_inserter(finite), is_finite);
  const std::vector<double> of_finite = distances2_of_finite(finite, pool);
  std::vector<double> means(points.size(), std::numeric_limits<double>::quiet_NaN());
  auto next = of_finite.begin();
  for (std::size_t i = 0; i < points.size(); ++i)
    if (is_finite(points[i])) means[i] = *next++;
  return means;
}

}  // namespace qs::train
