// SPDX-License-Identifier: MIT
//
// A forest of pairs: rounds of mutually nearest pairs, nearest by the error of merging them at
// pixels 0.6 of the node's size. Then its levels: the error and the gain of every node at a few
// footprints. The result depends on the items and their order alone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "learn/lod/merging.h"
#include "raster/pages/lod_node.h"

namespace qs {

/// A tree of pairs for each root. Children have smaller numbers than their parents.
struct PairForest {
  std::vector<LodGaussian> nodes;  ///< the items, then the merged nodes
  std::size_t items = 0;
  std::vector<std::array<std::uint32_t, 2>> children;  ///< of node items + i
  std::vector<std::uint32_t> roots;                    ///< near each other in space and in the list
};

/// Merges the items until `roots` nodes are left, at least 1; fewer items stay as they are.
PairForest merge_pairs(std::vector<LodGaussian> items, std::size_t roots, bool antialiased);

/// An item's levels, or the levels of a node.
struct NodeLevels {
  std::array<float, kLodFootprints> errors{};  ///< as pair_errors(), against the leaves
  LodSteps gains{};                            ///< see LodNode
  float radius = 0;                            ///< of the ball around the centres of the leaves
};

/// The levels of all nodes. `items` has the levels of the items. `footprint`: the smallest one,
/// world units.
std::vector<NodeLevels> levels_of(const PairForest& forest, std::vector<NodeLevels> items,
                                  float footprint, bool antialiased);

/// The forest without the nodes that no cut would show: their gains are nearly their
/// parents' gains. The roots come first, then layers: a quarter of a page of the nodes
/// with the largest gains, then layers of twice the size. A layer is in order of depth, so a page
/// has nodes of one part of the scene, and a view reads few pages.
struct FlatForest {
  struct Node {
    std::uint32_t number, parent;  ///< of the PairForest; of this forest, its own for roots
    std::uint32_t first_child = 0, child_count = 0;  ///< of this forest
  };
  std::vector<Node> nodes;
};
FlatForest flattened(const PairForest& forest, const std::vector<NodeLevels>& levels);

}  // namespace qs
