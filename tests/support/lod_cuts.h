// SPDX-License-Identifier: MIT
//
// Cuts of whole trees by given gains.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "learn/lod/cut.h"
#include "support/pool.h"

namespace qs::test {

/// The same footprint for all nodes.
inline LodGains gains_at(const RadLevels& levels, float footprint) {
  LodGains result;
  result.footprints.assign(levels.nodes.size(), footprint);
  for (const LodFacts& node : levels.nodes)
    result.gains.push_back(lod_gain(node, levels.footprint, footprint));
  return result;
}

/// The best cut with at most `budget` nodes, or the root alone. Ascending.
inline std::vector<std::uint32_t> choose_cut(const RadLevels& levels, const LodGains& gains,
                                             std::size_t budget) {
  const std::uint64_t count = levels.nodes.size();
  const LodPages tree{
      count, count, levels.footprint, {std::make_shared<const LodPage>(LodPage{{}, levels.nodes})}};
  const LodCut chosen = cut_of(
      tree, [&](const LodPage&, std::size_t row) { return gains.gains[row]; }, {budget}, pool());
  std::vector<std::uint32_t> cut;
  chosen.parts[0].for_each([&](std::size_t i) { cut.push_back(static_cast<std::uint32_t>(i)); });
  return cut;
}

}  // namespace qs::test
