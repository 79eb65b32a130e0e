// SPDX-License-Identifier: MIT
#include "learn/lod/pair_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "base/morton.h"
#include "base/rank.h"
#include "learn/lod/pair_errors.h"
#include "raster/scene/radix_sort.h"

namespace qs {
namespace {

constexpr std::size_t kWindow = 4;  // places that an order is searched, from the node's own on
constexpr float kMergedInARound = 0.25f;  // of the nodes: the cheapest pairs
constexpr float kPixelOfSize = 0.6f;      // the footprint at which a pair is judged
constexpr float kDilationPx = 0.3f;       // variance of the filter, px^2
constexpr std::uint32_t kNone = ~0u;
constexpr std::size_t kTile = 256;           // Gaussians whose planes stay in the cache
constexpr std::size_t kLayerNodes = 16'384;  // of the first layer, a quarter of a page

// Middle 98 % of the coordinates, as one cube, so that far Gaussians do not make the cells coarse.
struct Cube {
  glm::vec3 low{0};
  float side = 1;
};

Cube cube_around(const std::vector<glm::vec3>& means) {
  Cube cube{{}, 0};
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> values;
    for (const glm::vec3& mean : means) values.push_back(mean[axis]);
    cube.low[axis] = quantile(values, 0.01);
    cube.side = std::max(cube.side, quantile(values, 0.99) - cube.low[axis]);
  }
  cube.side = std::max(cube.side, 1e-20f);
  return cube;
}

class CurveOrder {
 public:
  explicit CurveOrder(const Cube& cube) : cube_(cube) {}

  /// The nodes `active` along a Morton curve that is moved by a fraction of the cube.
  std::span<const std::uint32_t> sorted(const std::vector<glm::vec3>& means,
                                        const std::vector<std::uint32_t>& active, glm::vec3 shift) {
    constexpr int kBits = 14, kHalf = 3 * kBits / 2;  // of a cell's coordinate, of half of a code
    constexpr std::uint32_t kMost = (1u << kHalf) - 1;
    constexpr float kCells = 1 << kBits;
    const float scale = kCells / (3 * cube_.side);
    const glm::vec3 start = (0.5f + shift) * (kCells / 3);
    codes_.resize(active.size());
    items_.resize(active.size());
    for (std::uint32_t i = 0; i < active.size(); ++i) {
      const glm::vec3 at = glm::clamp((means[active[i]] - cube_.low) * scale + start, glm::vec3(0),
                                      glm::vec3(kCells - 1));
      codes_[i] = morton_code(static_cast<std::uint64_t>(at.x), static_cast<std::uint64_t>(at.y),
                              static_cast<std::uint64_t>(at.z));
      items_.keys[i] = static_cast<std::uint32_t>(codes_[i] & kMost);
      items_.values[i] = i;
    }
    radix_sort(items_, {0, kMost}, alone_);
    for (std::size_t i = 0; i < active.size(); ++i)
      items_.keys[i] = static_cast<std::uint32_t>(codes_[items_.values[i]] >> kHalf);
    radix_sort(items_, {0, kMost}, alone_);
    for (std::uint32_t& value : items_.values) value = active[value];
    return items_.values;
  }

 private:
  Cube cube_;
  ThreadPool alone_{1};
  SortItems items_;
  Array<std::uint64_t> codes_;
};

// The cheapest partner that a node has been offered.
struct Nearest {
  float error = std::numeric_limits<float>::infinity();
  std::uint32_t node = kNone;

  void offer(float other_error, std::uint32_t other) {
    if (other_error < error || (other_error == error && other < node)) *this = {other_error, other};
  }
};

// Numbers the merged nodes in order of depth, so that passes over the forest find the nodes below a
// node near it.
void sort_by_depth(PairForest& forest) {
  std::vector<std::uint32_t> stack = forest.roots, order;
  // A parent comes before its children, and its second child's tree before its first child's.
  while (!stack.empty()) {
    const std::uint32_t node = stack.back();
    stack.pop_back();
    if (node < forest.items) continue;
    order.push_back(node);
    for (const std::uint32_t child : forest.children[node - forest.items]) stack.push_back(child);
  }
  std::ranges::reverse(order);
  std::vector<std::uint32_t> number(forest.nodes.size());
  std::iota(number.begin(), number.end(), 0u);
  std::vector<LodGaussian> merged;
  merged.reserve(order.size());
  auto children = forest.children;
  for (std::size_t i = 0; i < order.size(); ++i) {
    number[order[i]] = static_cast<std::uint32_t>(forest.items + i);
    merged.push_back(forest.nodes[order[i]]);
    for (std::size_t k = 0; k < 2; ++k)
      children[i][k] = number[forest.children[order[i] - forest.items][k]];
  }
  std::ranges::copy(merged, forest.nodes.begin() + static_cast<std::ptrdiff_t>(forest.items));
  forest.children = std::move(children);
  for (std::uint32_t& root : forest.roots) root = number[root];
}

// Offers each node the nodes at most kWindow - 1 places away in an order.
void find_nearest(const std::vector<LodGaussian>& nodes, std::span<const std::uint32_t> order,
                  const PairFilter& filter, std::vector<Nearest>& nearest) {
  LodPlanes tile;
  tile.resize(kTile + kWindow);
  std::array<float, kTile> errors;
  std::array<Nearest, kTile + kWindow> best;
  for (std::size_t begin = 0; begin < order.size(); begin += kTile) {
    const auto part = order.subspan(begin, std::min(kTile + kWindow - 1, order.size() - begin));
    for (std::size_t i = 0; i < part.size(); ++i) {
      constexpr std::size_t kAhead = 8;
      __builtin_prefetch(&nodes[order[std::min(begin + i + kAhead, order.size() - 1)]]);
      tile.set(i, nodes[part[i]]);
      best[i] = nearest[part[i]];
    }
    for (std::size_t step = 1; step < std::min(kWindow, part.size()); ++step) {
      const std::size_t pairs = std::min(kTile, part.size() - step);
      pair_errors(tile, 0, tile, step, pairs, filter, errors.data());
      for (std::size_t i = 0; i < pairs; ++i) {
        best[i].offer(errors[i], part[i + step]);
        best[i + step].offer(errors[i], part[i]);
      }
    }
    for (std::size_t i = 0; i < part.size(); ++i) nearest[part[i]] = best[i];
  }
}

}  // namespace

PairForest merge_pairs(std::vector<LodGaussian> items, std::size_t roots, bool antialiased) {
  PairForest forest{std::move(items), 0, {}, {}};
  auto& nodes = forest.nodes;
  forest.items = nodes.size();
  roots = std::max<std::size_t>(roots, 1);
  nodes.reserve(2 * nodes.size());
  auto& active = forest.roots;
  active.resize(nodes.size());
  std::iota(active.begin(), active.end(), 0u);
  std::vector<glm::vec3> means;  // side by side, because the orders need nothing else
  means.reserve(2 * nodes.size());
  for (const LodGaussian& node : nodes) means.push_back(node.mean);
  CurveOrder curve(cube_around(means));
  std::vector<Nearest> nearest(2 * nodes.size());  // in all rounds so far
  std::vector<bool> is_merged(2 * nodes.size());
  std::vector<std::pair<float, std::uint32_t>> pairs;
  const PairFilter filter{0, kDilationPx * kPixelOfSize * kPixelOfSize, antialiased};
  for (int round = 0; active.size() > roots; ++round) {
    for (const std::uint32_t x : active)
      if (nearest[x].node != kNone && is_merged[nearest[x].node]) nearest[x] = {};
    for (int order = 0; order < 2; ++order) {
      const auto fraction = [&](float step) {
        const float shift = step * static_cast<float>(2 * round + order);
        return shift - std::floor(shift);
      };
      find_nearest(
          nodes,
          curve.sorted(means, active, {fraction(0.382f), fraction(0.649f), fraction(0.878f)}),
          filter, nearest);
    }
    pairs.clear();
    for (const std::uint32_t x : active)
      if (const std::uint32_t y = nearest[x].node; y != kNone && x < y && nearest[y].node == x)
        pairs.emplace_back(nearest[x].error, x);
    const auto count = static_cast<float>(active.size());
    const auto most = static_cast<std::size_t>(kMergedInARound * count) + 1;
    if (const std::size_t kept = std::min(most, active.size() - roots); kept < pairs.size()) {
      std::ranges::nth_element(pairs, pairs.begin() + static_cast<std::ptrdiff_t>(kept));
      pairs.resize(kept);
    }
    std::ranges::sort(pairs, {}, &std::pair<float, std::uint32_t>::second);
    for (const auto& [error, x] : pairs) {
      const std::uint32_t y = nearest[x].node;
      forest.children.push_back({x, y});
      active.push_back(static_cast<std::uint32_t>(nodes.size()));
      nodes.push_back(merged(nodes[x], nodes[y]));
      means.push_back(nodes.back().mean);
      is_merged[x] = is_merged[y] = true;
    }
    std::erase_if(active, [&](std::uint32_t x) { return is_merged[x]; });
  }
  std::ranges::copy(curve.sorted(means, active, {}), active.begin());
  sort_by_depth(forest);
  return forest;
}

namespace {

// Heaps of blocks by gain, the largest first (leftist heaps, Crane 1972).
struct Blocks {
  std::vector<std::uint32_t> left, right, count;
  std::vector<std::uint8_t> depth;
  std::vector<float> error, gain;

  explicit Blocks(std::size_t nodes)
      : left(nodes, kNone),
        right(nodes, kNone),
        count(nodes),
        depth(nodes),
        error(nodes),
        gain(nodes) {}

  std::uint32_t joined(std::uint32_t a, std::uint32_t b) {
    if (a == kNone) return b;
    if (b == kNone) return a;
    if (gain[b] > gain[a] || (gain[b] == gain[a] && b < a)) std::swap(a, b);
    right[a] = joined(right[a], b);
    const auto depth_of = [&](std::uint32_t i) { return i == kNone ? 0 : depth[i] + 1; };
    if (depth_of(left[a]) < depth_of(right[a])) std::swap(left[a], right[a]);
    depth[a] = static_cast<std::uint8_t>(depth_of(right[a]));
    return a;
  }
};

}  // namespace

std::vector<NodeLevels> levels_of(const PairForest& forest, std::vector<NodeLevels> levels,
                                  float footprint, bool antialiased) {
  const std::size_t items = forest.items, count = forest.nodes.size();
  levels.resize(count);
  for (std::size_t i = items; i < count; ++i)
    for (const std::uint32_t child : forest.children[i - items])
      levels[i].radius =
          std::max(levels[i].radius, glm::length(forest.nodes[child].mean - forest.nodes[i].mean) +
                                         levels[child].radius);
  // The gain of a merge is its error per Gaussian saved. If the merge above is cheaper, both become
  // a block with their mean, which is the order of the best cuts (Chou, Lookabaugh, Gray 1989).
  Blocks blocks(count);
  LodPlanes first, second;
  first.resize(kTile);
  second.resize(kTile);
  std::array<float, kTile> errors;
  for (std::size_t begin = items; begin < count; begin += kTile) {
    const std::size_t some = std::min(kTile, count - begin);
    for (std::size_t i = 0; i < some; ++i) {
      first.set(i, forest.nodes[forest.children[begin - items + i][0]]);
      second.set(i, forest.nodes[forest.children[begin - items + i][1]]);
    }
    for (std::size_t k = 0; k < kLodFootprints; ++k) {
      const float side = lod_footprint(footprint, k), v = kDilationPx * side * side;
      pair_errors(first, 0, second, 0, some, {v, 0, antialiased}, errors.data());
      for (std::size_t i = 0; i < some; ++i) {
        // Many nodes share a pixel that is larger than they are, and hide each other's errors.
        const LodCovariance& c = forest.nodes[begin + i].covariance;
        const float size = (c[0] + c[3] + c[5]) / 2;
        levels[begin + i].errors[k] = errors[i] * size / (size + v + 1e-30f);
      }
    }
  }
  for (std::size_t k = 0; k < kLodFootprints; ++k) {
    for (std::size_t i = items; i < count; ++i) {
      const auto [a, b] = forest.children[i - items];
      const float own = levels[i].errors[k];
      levels[i].errors[k] += levels[a].errors[k] + levels[b].errors[k];
      const auto heap_of = [&](std::uint32_t child) { return child < items ? kNone : child; };
      std::uint32_t below = blocks.joined(heap_of(a), heap_of(b));
      blocks.error[i] = own;
      blocks.count[i] = 1;
      while (below != kNone &&
             blocks.gain[below] * static_cast<float>(blocks.count[i]) > blocks.error[i]) {
        blocks.error[i] += blocks.error[below];
        blocks.count[i] += blocks.count[below];
        below = blocks.joined(blocks.left[below], blocks.right[below]);
      }
      blocks.gain[i] = blocks.error[i] / static_cast<float>(blocks.count[i]);
      blocks.left[i] = below;
      blocks.right[i] = kNone;
      blocks.depth[i] = 0;
    }
    for (std::size_t i = count; i-- > items;)
      for (const std::uint32_t child : forest.children[i - items])
        if (child >= items) blocks.gain[child] = std::min(blocks.gain[child], blocks.gain[i]);
    for (std::size_t i = items; i < count; ++i) {
      // In h^2 the gain falls; parents gain at least as much as their children.
      std::uint8_t& step = levels[i].gains[k];
      step = lod_step(blocks.gain[i], footprint);
      if (k > 0)
        step = static_cast<std::uint8_t>(
            std::min<int>(step, levels[i].gains[k - 1] + kLodStepsOfFootprint));
      for (const std::uint32_t child : forest.children[i - items])
        step = std::max(step, levels[child].gains[k]);
    }
  }
  return levels;
}

namespace {

// Orders the nodes of a forest in order of breadth by layers, and in each layer by depth.
FlatForest in_layers(const FlatForest& flat, std::size_t roots,
                     const std::vector<NodeLevels>& levels) {
  const auto& nodes = flat.nodes;
  std::vector<std::uint32_t> parents, preorder(nodes.size()), stack;
  std::vector<int> gains(nodes.size());
  std::vector<std::size_t> layers(nodes.size());
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    const LodSteps& steps = levels[nodes[i].number].gains;
    gains[i] = std::accumulate(steps.begin(), steps.end(), 0);
    if (nodes[i].child_count > 0) parents.push_back(i);
  }
  for (std::size_t i = roots; i-- > 0;) stack.push_back(static_cast<std::uint32_t>(i));
  for (std::uint32_t place = 0; !stack.empty(); ++place) {
    const std::uint32_t i = stack.back();
    stack.pop_back();
    preorder[i] = place;
    for (std::uint32_t k = nodes[i].child_count; k-- > 0;)
      stack.push_back(nodes[i].first_child + k);
  }
  // A parent comes before its children in both orders: its gain is at least as large.
  std::ranges::stable_sort(parents, std::ranges::greater(), [&](auto i) { return gains[i]; });
  std::size_t before = 0;
  for (const std::uint32_t i : parents) {
    layers[i] = static_cast<std::size_t>(std::bit_width(before / kLayerNodes + 1));
    before += nodes[i].child_count;
  }
  std::ranges::sort(parents, {}, [&](auto i) { return std::pair(layers[i], preorder[i]); });
  FlatForest result;
  std::vector<std::uint32_t> place(nodes.size());
  std::iota(place.begin(), place.end(), 0u);
  result.nodes.assign(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(roots));
  for (const std::uint32_t i : parents) {
    FlatForest::Node& parent = result.nodes[place[i]];
    parent.first_child = static_cast<std::uint32_t>(result.nodes.size());
    for (std::uint32_t k = 0; k < nodes[i].child_count; ++k) {
      const std::uint32_t child = nodes[i].first_child + k;
      place[child] = static_cast<std::uint32_t>(result.nodes.size());
      result.nodes.push_back(nodes[child]);
      result.nodes.back().parent = place[i];
    }
  }
  return result;
}

}  // namespace

FlatForest flattened(const PairForest& forest, const std::vector<NodeLevels>& levels) {
  constexpr int kSameGain = 4;  // steps
  constexpr std::size_t kMostChildren = 64;
  FlatForest flat;
  auto& nodes = flat.nodes;
  for (std::uint32_t i = 0; i < forest.roots.size(); ++i) nodes.push_back({forest.roots[i], i});
  std::vector<std::uint32_t> below, next;
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    const std::uint32_t number = nodes[i].number;
    if (number < forest.items) continue;
    const auto is_shown = [&](std::uint32_t child) {
      if (child < forest.items) return true;
      for (std::size_t k = 0; k < kLodFootprints; ++k)
        if (levels[number].gains[k] - levels[child].gains[k] > kSameGain) return true;
      return false;
    };
    const auto& pair = forest.children[number - forest.items];
    below.assign(pair.begin(), pair.end());
    for (bool opened = true; opened && below.size() < kMostChildren;) {
      opened = false;
      next.clear();
      for (const std::uint32_t child : below) {
        if (is_shown(child)) {
          next.push_back(child);
          continue;
        }
        opened = true;
        for (const std::uint32_t each : forest.children[child - forest.items]) next.push_back(each);
      }
      below.swap(next);
    }
    nodes[i].first_child = static_cast<std::uint32_t>(nodes.size());
    nodes[i].child_count = static_cast<std::uint32_t>(below.size());
    for (const std::uint32_t child : below) nodes.push_back({child, i});
  }
  return in_layers(flat, forest.roots.size(), levels);
}

}  // namespace qs
