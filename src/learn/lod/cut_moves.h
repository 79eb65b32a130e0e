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

/// Groups that lead from one cut to another. After each group the nodes are a cut, unless a page
/// between the cuts has left the memory: then nodes above missing pages come before those go. The
/// last group has all nodes of unknown places: the two cuts are far apart there.
std::vector<LodMoves> moves_between(const LodPages& tree, const LodCut& from, const LodCut& to,
                                    ThreadPool& pool);

}  // namespace qs
