// SPDX-License-Identifier: MIT
//
// The nodes in which two cuts of a tree differ, in groups that change independently.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "raster/pages/cut.h"

namespace qs {

struct LodMove {
  std::uint32_t page, row;
};

/// Nodes that go and the nodes that come in their place: a node and nodes below it.
struct LodMoves {
  std::vector<LodMove> go, come;
};

/// Groups that lead from one cut to another: after each group the drawn nodes are a cut, with at
/// most as many nodes as the larger one of the two. The last
/// group has the nodes whose counterparts were not found a few steps down the tree. If a page
/// between the cuts has left the memory, nodes below it go in that group, after a node above them
/// may have come.
std::vector<LodMoves> moves_between(const LodPages& tree, const LodCut& from, const LodCut& to,
                                    ThreadPool& pool);

}  // namespace qs
