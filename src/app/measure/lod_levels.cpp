// SPDX-License-Identifier: MIT
#include "app/measure/lod_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <random>
#include <tuple>
#include <utility>

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "io/cloud/cloud_memory.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/cloud_order.h"
#include "raster/scene/transform.h"

namespace qs {
namespace {

constexpr double kOpaque = 0.99;  // opacity of merged Gaussians, at most
constexpr std::size_t kMostChildren = std::numeric_limits<std::uint16_t>::max();

// Surface of the ellipsoid of one standard deviation (Thomsen's formula): four times the mean of
// its projections.
double ellipsoid_area(const glm::vec3& log_scale) {
  constexpr double kPower = 1.6075;
  const glm::dvec3 s = glm::max(glm::exp(glm::dvec3(log_scale)), glm::dvec3(1e-7));
  const double sum =
      std::pow(s.x * s.y, kPower) + std::pow(s.x * s.z, kPower) + std::pow(s.y * s.z, kPower);
  return 4 * std::numbers::pi * std::pow(sum / 3, 1 / kPower);
}

double longest_axis(const GaussianCloud& cloud, std::size_t i) {
  const glm::vec3& s = cloud.log_scales[i];
  return 2 * std::exp(static_cast<double>(std::max({s.x, s.y, s.z})));
}

float logit_of(double opacity) { return static_cast<float>(std::log(opacity / (1 - opacity))); }

class OctreeBuilder {
 public:
  OctreeBuilder(const GaussianCloud& leaves, ThreadPool& pool)
      : pool_(pool), nodes_(leaves), weights_(leaves.size()) {
    pool_.for_each(leaves.size(), 4096, [&](std::size_t i) {
      weights_[i] =
          opacity_of_logit(leaves.opacity_logits[i]) * ellipsoid_area(leaves.log_scales[i]) + 1e-30;
    });
    origin_ = leaves.positions[0];
    for (const glm::vec3& position : leaves.positions)
      origin_ = glm::min(origin_, glm::dvec3(position));
    origin_ -= 1e-3;
  }

  Octree build() {
    std::vector<std::uint32_t> waiting(nodes_.size());  // leaves, the smallest first
    std::iota(waiting.begin(), waiting.end(), 0u);
    std::ranges::stable_sort(waiting, {}, [&](std::uint32_t i) { return size(i); });
    double step = std::exp2(std::floor(std::log2(std::max(size(waiting[0]), 1e-6))));
    std::vector<std::uint32_t> active;
    for (std::size_t next = 0; next < waiting.size() || active.size() > 1; step *= 2) {
      while (next < waiting.size() && size(waiting[next]) <= step)
        active.push_back(waiting[next++]);
      merge_level(step, active);
    }
    return from_root(waiting.size());
  }

 private:
  double size(std::uint32_t node) const { return longest_axis(nodes_, node); }

  // The last node is the root.
  Octree from_root(std::size_t leaves) const {
    auto page = std::make_shared<LodPage>();
    Octree octree;
    std::vector<std::uint32_t> order{static_cast<std::uint32_t>(nodes_.size() - 1)};
    for (std::size_t i = 0; i < order.size(); ++i) {
      LodFacts node;
      const bool is_leaf = order[i] < leaves;
      if (!is_leaf) {
        const std::vector<std::uint32_t>& children = children_[order[i] - leaves];
        node.first_child = static_cast<std::uint32_t>(order.size());
        node.child_count = static_cast<std::uint16_t>(children.size());
        order.insert(order.end(), children.begin(), children.end());
      }
      octree.order.push_back(is_leaf ? 0 : static_cast<float>(order[i] - leaves + 1));
      page->nodes.push_back(node);
      page->numbers.push_back(is_leaf ? order[i] : kNoNumber);
    }
    page->cloud = select(nodes_, order);
    octree.tree = {nodes_.size(), nodes_.size(), 0, {page}};
    return octree;
  }

  struct Member {
    glm::dvec3 cell;
    std::uint32_t node;
  };

  // Merges the nodes of each cell of the width `step`. `active` loses them and gets their parents.
  void merge_level(double step, std::vector<std::uint32_t>& active) {
    std::vector<Member> ready;
    std::vector<std::uint32_t> left;
    for (const std::uint32_t node : active) {
      const glm::dvec3 cell = glm::floor((glm::dvec3(nodes_.positions[node]) - origin_) / step);
      size(node) <= step ? ready.push_back({cell, node}) : left.push_back(node);
    }
    const auto key = [](const Member& m) {
      return std::tuple(m.cell.z, m.cell.y, m.cell.x, m.node);
    };
    std::ranges::sort(ready, {}, key);
    std::vector<std::span<const Member>> groups;
    for (std::size_t begin = 0, end = 0; begin < ready.size(); begin = end) {
      while (end < ready.size() && ready[end].cell == ready[begin].cell &&
             end - begin < kMostChildren)
        ++end;
      if (end - begin > 1)
        groups.push_back(std::span(ready).subspan(begin, end - begin));
      else
        left.push_back(ready[begin].node);
    }
    add_parents(groups, left);
    active = std::move(left);
  }

  // Appends a node for each group, the cheapest first.
  void add_parents(const std::vector<std::span<const Member>>& groups,
                   std::vector<std::uint32_t>& active) {
    GaussianCloud made;
    made.resize(groups.size(), nodes_.sh_degree);
    std::vector<double> weights(groups.size()), costs(groups.size());
    pool_.for_each(groups.size(), 256, [&](std::size_t i) {
      std::tie(weights[i], costs[i]) = merge(groups[i], made, i);
    });
    std::vector<std::size_t> order(groups.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return costs[i]; });
    const std::size_t first = nodes_.size();
    nodes_.resize(first + groups.size(), nodes_.sh_degree);
    for (std::size_t k = 0; k < order.size(); ++k) {
      const auto node = static_cast<std::uint32_t>(first + k);
      copy_gaussian(made, order[k], nodes_, node);
      weights_.push_back(weights[order[k]]);
      std::vector<std::uint32_t>& children = children_.emplace_back();
      for (const Member& member : groups[order[k]]) children.push_back(member.node);
      active.push_back(node);
    }
  }

  // Fills Gaussian k of `made`. Returns its weight, and the weight times the trace of the spread.
  std::pair<double, double> merge(std::span<const Member> group, GaussianCloud& made,
                                  std::size_t k) const {
    double weight = 0;
    glm::dvec3 mean(0);
    for (const Member& m : group) {
      weight += weights_[m.node];
      mean += weights_[m.node] * glm::dvec3(nodes_.positions[m.node]);
    }
    mean /= weight;
    made.positions[k] = mean;
    glm::vec3* const sh = sh_of(made, k);
    std::fill_n(sh, sh_count(made), glm::vec3(0));
    glm::dmat3 covariance(0);
    double spread = 0;
    for (const Member& m : group) {
      const double share = weights_[m.node] / weight;
      const glm::dvec3 d = glm::dvec3(nodes_.positions[m.node]) - mean;
      const auto c = world_covariance(nodes_, m.node);
      covariance += share * (glm::dmat3(c.xx, c.xy, c.xz, c.xy, c.yy, c.yz, c.xz, c.yz, c.zz) +
                             glm::outerProduct(d, d));
      spread += share * glm::dot(d, d);
      for (std::size_t j = 0; j < sh_count(made); ++j)
        sh[j] += static_cast<float>(share) * sh_of(std::as_const(nodes_), m.node)[j];
    }
    set_covariance(made, k, covariance);
    made.opacity_logits[k] =
        logit_of(std::min(weight / ellipsoid_area(made.log_scales[k]), kOpaque));
    return {weight, spread * weight};
  }

  ThreadPool& pool_;
  GaussianCloud nodes_;
  std::vector<std::vector<std::uint32_t>> children_;  // of the merged nodes
  std::vector<double> weights_;                       // opacity x area, without a limit
  glm::dvec3 origin_{0};
};

}  // namespace

GaussianCloud uniform_sample(const GaussianCloud& cloud, std::size_t count) {
  std::vector<std::uint32_t> chosen;
  std::mt19937_64 random(1);
  for (std::size_t i = 0; i < cloud.size(); ++i)  // each subset is equally likely
    if (random() % (cloud.size() - i) < count - chosen.size())
      chosen.push_back(static_cast<std::uint32_t>(i));
  GaussianCloud sample = select(cloud, chosen);
  for (std::size_t i = 0; i < sample.size(); ++i) {
    const double opacity = opacity_of_logit(sample.opacity_logits[i]);
    const double wanted = opacity * static_cast<double>(cloud.size()) / static_cast<double>(count);
    const double possible = std::max(opacity, std::min(wanted, kOpaque));
    if (possible > opacity) sample.opacity_logits[i] = logit_of(possible);
    if (wanted > possible)
      sample.log_scales[i] += static_cast<float>(0.5 * std::log(wanted / possible));
  }
  return sample;
}

Octree octree_of(const GaussianCloud& leaves, ThreadPool& pool) {
  return OctreeBuilder(leaves, pool).build();
}

LodGain gain_by_distance(std::span<const LodView> views) {
  return LodGain([views](const LodPage& page, std::size_t row) {
    double most = 0;
    for (const LodView& view : views) {
      const Camera& camera = view.camera;
      const double distance =
          glm::distance(camera.position(), glm::dvec3(page.cloud.positions[row]));
      most = std::max(most, camera.focal_px.y * longest_axis(page.cloud, row) /
                                std::max(distance, camera.near_depth));
    }
    return static_cast<float>(most);
  });
}

GaussianCloud all_nodes(const LodPages& tree) {
  const GaussianCloud& top = tree.pages[0]->cloud;
  GaussianCloud all = make_cloud(tree.count, top.sh_degree);
  all.antialiased = top.antialiased;
  all.origin = top.origin;
  for (std::size_t k = 0; k < tree.count; ++k)
    copy_gaussian(tree.pages[k / tree.page_nodes]->cloud, k % tree.page_nodes, all, k);
  return all;
}

LodCut cut_in_view(const LodPages& tree, const LodGain& gain, std::size_t budget,
                   const std::vector<bool>& in_view, ThreadPool& pool) {
  const auto seen = [&](std::size_t nodes) {
    LodCut cut = cut_of(tree, gain, {nodes}, pool);
    cut.count = 0;
    for (LodPart& part : cut.parts) {
      part.count = 0;
      part.for_each([&](std::size_t row) {
        if (in_view[part.page * tree.page_nodes + row])
          ++part.count;
        else
          part.mask.toggle(row);
      });
      cut.count += part.count;
    }
    return cut;
  };
  LodCut best = seen(budget);
  for (std::size_t low = budget, high = tree.count; low < high;) {
    const std::size_t middle = low + (high - low + 1) / 2;
    LodCut cut = seen(middle);
    if (cut.count > budget) {
      high = middle - 1;
    } else {
      low = middle;
      best = std::move(cut);
    }
  }
  return best;
}

}  // namespace qs
