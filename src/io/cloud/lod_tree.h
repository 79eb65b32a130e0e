// SPDX-License-Identifier: MIT
//
// Trees of levels of detail, which several formats store alike: node 0 is the root, the children of
// a node are consecutive and come after it, and nodes without children are leaves.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/fail.h"

namespace qs {

struct LodChildren {
  std::uint64_t first = 0, count = 0;
};

struct LodTree {
  std::uint32_t levels = 0;           ///< nodes on the longest way from the root to a leaf
  std::vector<std::uint32_t> leaves;  ///< the nodes without children, in increasing order
};

/// Checks a tree of 1 to 2^32 nodes; `children_of(i)` returns the LodChildren of node i. Throws
/// Error(input) "source: ..." unless every node but the root is the child of exactly one node.
/// Children come after their parent, so a sound tree has no cycles.
template <class ChildrenOf>
LodTree read_lod_tree(std::uint64_t nodes, const ChildrenOf& children_of,
                      const std::string& source) {
  LodTree tree;
  std::vector<std::uint32_t> levels(nodes);  // 0: no parent so far
  levels[0] = 1;
  for (std::uint64_t i = 0; i < nodes; ++i) {
    if (levels[i] == 0) fail("{}: node {} of its tree is the child of no node", source, i);
    tree.levels = std::max(tree.levels, levels[i]);
    const LodChildren children = children_of(i);
    if (children.count == 0) {
      tree.leaves.push_back(static_cast<std::uint32_t>(i));
      continue;
    }
    if (children.first <= i)
      fail("{}: the children of node {} begin with node {}, but must come after it", source, i,
           children.first);
    if (children.first > nodes || children.count > nodes - children.first)
      fail("{}: node {} has {} children from node {} on, but its tree has {} nodes", source, i,
           children.count, children.first, nodes);
    for (std::uint64_t child = children.first; child < children.first + children.count; ++child) {
      if (levels[child] != 0) fail("{}: node {} is the child of two nodes", source, child);
      levels[child] = levels[i] + 1;
    }
  }
  return tree;
}

}  // namespace qs
