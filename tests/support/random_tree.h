// SPDX-License-Identifier: MIT
//
// Trees with levels of detail in pages, for tests of cuts.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "raster/pages/cut.h"

namespace qs::test {

/// A tree in order of breadth whose nodes have up to 5 children; `radius` of a node is its gain
/// for gain_of_scale(). All pages are in memory.
inline LodPages random_tree(std::size_t nodes, std::uint64_t page_nodes, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<LodFacts> all(nodes);
  GaussianCloud cloud;
  cloud.resize(nodes, 0);
  std::uint32_t next = 1;
  for (std::uint32_t i = 0; i < nodes; ++i) {
    const std::uint32_t left = static_cast<std::uint32_t>(nodes) - next;
    const std::uint32_t wish = next == i + 1 ? 2 + random() % 4 : random() % 6;
    const std::uint32_t count = std::min(wish, left);
    all[i].child_count = static_cast<std::uint16_t>(count);
    all[i].first_child = count > 0 ? next : 0;
    for (std::uint32_t c = 0; c < count; ++c) all[next + c].parent = i;
    next += count;
    all[i].radius = static_cast<float>(random() % 16) / 16 + (i == 0 ? 1 : 0);
    cloud.positions[i] = {static_cast<float>(i), 0, 1};
    cloud.log_scales[i] = glm::vec3(0);
    cloud.rotations[i] = glm::quat(1, 0, 0, 0);
    cloud.opacity_logits[i] = 0;
    cloud.sh[i] = glm::vec3(0);
  }
  LodPages tree{nodes, page_nodes, 0};
  for (std::size_t begin = 0; begin < nodes; begin += page_nodes) {
    const std::size_t end = std::min<std::size_t>(nodes, begin + page_nodes);
    auto page = std::make_shared<LodPage>();
    page->nodes.assign(all.begin() + static_cast<std::ptrdiff_t>(begin),
                       all.begin() + static_cast<std::ptrdiff_t>(end));
    page->cloud.resize(end - begin, 0);
    for (std::size_t i = begin; i < end; ++i) {
      page->cloud.positions[i - begin] = cloud.positions[i];
      page->cloud.log_scales[i - begin] = cloud.log_scales[i];
      page->cloud.rotations[i - begin] = cloud.rotations[i];
      page->cloud.opacity_logits[i - begin] = cloud.opacity_logits[i];
      page->cloud.sh[i - begin] = cloud.sh[i];
    }
    tree.pages.push_back(page);
  }
  return tree;
}

inline float gain_of_scale(const LodPage& page, std::size_t row) { return page.nodes[row].radius; }

inline const LodFacts& node_of(const LodPages& tree, std::uint64_t i) {
  return tree.pages[i / tree.page_nodes]->nodes[i % tree.page_nodes];
}

/// The nodes of a cut, in increasing order.
inline std::vector<std::uint64_t> nodes_of(const LodPages& tree, const LodCut& cut) {
  std::vector<std::uint64_t> nodes;
  for (const LodPart& part : cut.parts)
    part.for_each([&](std::size_t row) { nodes.push_back(part.page * tree.page_nodes + row); });
  return nodes;
}

/// The cut by opening one node after the other, the largest gain first.
inline std::vector<std::uint64_t> opened_one_by_one(const LodPages& tree, const LodLimit& limit) {
  const auto order = [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  };
  std::set<std::pair<float, std::uint64_t>, decltype(order)> closed(order);
  const auto gain = [&](std::uint64_t i, float above) {
    const LodFacts& node = node_of(tree, i);
    return node.child_count == 0 ? 0 : std::min(above, std::max(node.radius, 1e-30f));
  };
  closed.insert({gain(0, 1e30f), 0});
  for (std::size_t count = 1; !closed.empty();) {
    const auto [most, i] = *closed.begin();
    const LodFacts& node = node_of(tree, i);
    if (most == 0 || most <= limit.gain || count + node.child_count - 1 > limit.budget) break;
    closed.erase(closed.begin());
    count += node.child_count - 1u;
    for (std::uint32_t c = 0; c < node.child_count; ++c)
      closed.insert({gain(node.first_child + c, most), node.first_child + c});
  }
  std::vector<std::uint64_t> nodes;
  for (const auto& [most, i] : closed) nodes.push_back(i);
  std::ranges::sort(nodes);
  return nodes;
}

}  // namespace qs::test
