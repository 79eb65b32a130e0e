// SPDX-License-Identifier: MIT
#include "app/train/nearest.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>

#include <glm/geometric.hpp>

namespace qs::train {
namespace {

constexpr std::size_t kNeighbours = 3;

// The smallest squared distances so far, ascending.
struct Best {
  std::array<double, kNeighbours> distances2;

  Best() { distances2.fill(std::numeric_limits<double>::infinity()); }
  double worst() const { return distances2.back(); }
  void add(double distance2) {
    if (distance2 >= worst()) return;
    distances2.back() = distance2;
    std::sort(distances2.begin(), distances2.end());
  }
};

// A k-d tree in an array: the middle of a range divides it along the axis of its largest extent.
class Tree {
 public:
  explicit Tree(const std::vector<glm::vec3>& points)
      : points_(points), order_(points.size()), axes_(points.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    build(0, order_.size());
  }

  Best nearest(std::uint32_t to) const {
    Best best;
    search(0, order_.size(), to, best);
    return best;
  }

 private:
  void build(std::size_t begin, std::size_t end) {
    if (end - begin < 2) return;
    glm::vec3 low = points_[order_[begin]], high = low;
    for (std::size_t i = begin; i < end; ++i) {
      low = glm::min(low, points_[order_[i]]);
      high = glm::max(high, points_[order_[i]]);
    }
    const glm::vec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const std::size_t middle = (begin + end) / 2;
    const auto at = [this](std::size_t i) {
      return order_.begin() + static_cast<std::ptrdiff_t>(i);
    };
    std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
      return points_[a][axis] < points_[b][axis];
    });
    axes_[middle] = static_cast<std::uint8_t>(axis);
    build(begin, middle);
    build(middle + 1, end);
  }

  void search(std::size_t begin, std::size_t end, std::uint32_t to, Best& best) const {
    if (begin == end) return;
    const std::size_t middle = (begin + end) / 2;
    const std::uint32_t point = order_[middle];
    const glm::dvec3 offset = glm::dvec3(points_[to]) - glm::dvec3(points_[point]);
    if (point != to) best.add(glm::dot(offset, offset));
    if (end - begin == 1) return;
    const double beside = offset[axes_[middle]];
    const bool low_first = beside < 0;
    for (const bool low : {low_first, !low_first}) {
      if (low != low_first && beside * beside >= best.worst()) return;
      low ? search(begin, middle, to, best) : search(middle + 1, end, to, best);
    }
  }

  const std::vector<glm::vec3>& points_;
  std::vector<std::uint32_t> order_;
  std::vector<std::uint8_t> axes_;  // per middle of a range
};

}  // namespace

std::vector<double> neighbour_distances2(const std::vector<glm::vec3>& points, ThreadPool& pool) {
  const Tree tree(points);
  const std::size_t neighbours = std::min(kNeighbours, points.size() - 1);
  std::vector<double> means(points.size(), 0);
  if (points.size() < 2) return means;
  pool.for_chunks(points.size(), 1024, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const Best best = tree.nearest(static_cast<std::uint32_t>(i));
      for (std::size_t k = 0; k < neighbours; ++k)
        means[i] += best.distances2[k] / static_cast<double>(neighbours);
    }
  });
  return means;
}

}  // namespace qs::train
