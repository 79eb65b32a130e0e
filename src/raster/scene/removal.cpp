// SPDX-License-Identifier: MIT
#include "raster/scene/removal.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/vector_relational.hpp>

#include "base/rank.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/cells.h"
#include "raster/scene/cloud_order.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {
namespace {

constexpr int kLevels = 8;  // of grids

using Numbers = std::vector<std::uint32_t>;

// The longest side of the box that holds the middle 90 % per axis; 0 without finite centres.
float core_size(const GaussianCloud& cloud, const Numbers& of) {
  float longest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    auto values = finite_values(of, [&](std::uint32_t i) { return cloud.positions[i][axis]; });
    if (values.empty()) return 0;
    longest = std::max(longest, quantile(values, 0.95) - quantile(values, 0.05));
  }
  return longest;
}

struct Cell {
  std::uint64_t key = 0;
  std::uint32_t count = 0;
};

std::vector<Cell> merged(std::vector<Cell> cells) {
  std::ranges::sort(cells, {}, &Cell::key);
  std::size_t last = 0;
  for (std::size_t i = 1; i < cells.size(); ++i) {
    if (cells[i].key == cells[last].key) {
      cells[last].count += cells[i].count;
    } else {
      cells[++last] = cells[i];
    }
  }
  cells.resize(std::min(cells.size(), last + 1));
  return cells;
}

// Keys of the cells with at most `most` Gaussians in them and their 26 neighbours, ascending.
std::vector<std::uint64_t> lonely_cells(const std::vector<Cell>& cells, std::uint64_t most) {
  std::vector<std::uint64_t> sums(cells.size());
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      const std::uint64_t step = CellGrid::step(0, dy, dz);
      std::size_t begin = 0;
      for (std::size_t i = 0; i < cells.size(); ++i) {
        const std::uint64_t middle = cells[i].key + step;
        while (begin < cells.size() && cells[begin].key < middle - 1) ++begin;
        for (std::size_t at = begin; at < cells.size() && cells[at].key <= middle + 1; ++at)
          sums[i] += cells[at].count;
      }
    }
  }
  std::vector<std::uint64_t> lonely;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (sums[i] <= most) lonely.push_back(cells[i].key);
  return lonely;
}

Numbers isolated(const GaussianCloud& cloud, const Numbers& of, int fewest_neighbours,
                 const Progress& progress) {
  Numbers found;
  if (of.empty() || fewest_neighbours <= 0) return found;
  const auto grid = CellGrid::around(cloud, of);
  if (!grid) return found;

  // Count Gaussians per cell. A large Gaussian is looked up in a coarser grid.
  std::vector<Cell> cells;
  cells.reserve(of.size());
  std::array<Numbers, kLevels> of_level;
  for (const std::uint32_t i : of) {
    const auto key = grid->key(cloud.positions[i]);
    if (!key) {
      found.push_back(i);
      continue;
    }
    cells.push_back({*key, 1});
    const double larger =
        double{log_size(cloud, i)} - double{grid->median};  // NaN: the finest grid
    const double level = larger > 0 ? std::ceil(larger / std::log(1 << CellGrid::kFinerBits)) : 0;
    of_level[static_cast<std::size_t>(std::min(level, kLevels - 1.0))].push_back(i);
  }
  // From fine to coarse, find the Gaussians in cells with too few neighbours.
  for (int level = 0; level < kLevels; ++level) {
    if (level > 0)
      for (Cell& each : cells) each.key = CellGrid::coarser(each.key);
    progress.update(static_cast<float>(level) / static_cast<float>(kLevels));
    cells = merged(std::move(cells));
    const Numbers& here = of_level[static_cast<std::size_t>(level)];
    if (here.empty()) continue;
    const auto lonely = lonely_cells(cells, static_cast<std::uint64_t>(fewest_neighbours));
    if (lonely.empty()) break;  // then no cell of a coarser grid is lonely
    for (const std::uint32_t i : here) {
      std::uint64_t key = *grid->key(cloud.positions[i]);
      for (int coarse = 0; coarse < level; ++coarse) key = CellGrid::coarser(key);
      if (std::ranges::binary_search(lonely, key)) found.push_back(i);
    }
  }
  return found;
}

// The Gaussians that stay, in their order.
Numbers staying(const Removal& removal, const GaussianSet* among) {
  Numbers numbers;
  numbers.reserve(removal.marks.size());
  for (std::size_t i = 0; i < removal.marks.size(); ++i)
    if (removal.marks[i] == Removed::no && (among == nullptr || (*among)[i]))
      numbers.push_back(static_cast<std::uint32_t>(i));
  return numbers;
}

}  // namespace

Removal find_removal(const GaussianCloud& cloud, const std::optional<CropBox>& box,
                     const std::optional<Floaters>& floaters, const Progress& progress,
                     const GaussianSet* among) {
  Removal removal;
  removal.marks.assign(cloud.size(), Removed::no);
  // Mark Gaussians outside of the box.
  const auto is_there = [&](std::size_t i) { return among == nullptr || (*among)[i]; };
  if (box)
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (is_there(i) && !box->contains(cloud.positions[i])) removal.marks[i] = Removed::outside;
  // Mark floaters among the rest.
  if (floaters) {
    const Numbers inside = staying(removal, among);
    const float core = floaters->large ? core_size(cloud, inside) : 0;
    const double largest = core > 0 ? std::log(double{core} * double{floaters->largest_size})
                                    : std::numeric_limits<double>::infinity();
    for (const std::uint32_t i : inside) {
      if (floaters->faint &&
          !(opacity_of_logit(cloud.opacity_logits[i]) >= double{floaters->least_opacity})) {
        removal.marks[i] = Removed::faint;
      } else if (floaters->large && !(double{log_size(cloud, i)} <= largest)) {
        removal.marks[i] = Removed::large;
      }
    }
    if (floaters->isolated)
      for (const std::uint32_t i :
           isolated(cloud, staying(removal, among), floaters->fewest_neighbours, progress))
        removal.marks[i] = Removed::isolated;
  }
  for (std::size_t i = 0; i < cloud.size(); ++i)
    removal.counts[static_cast<std::size_t>(removal.marks[i])] += is_there(i);
  return removal;
}

GaussianCloud keep_rest(const GaussianCloud& cloud, const Removal& removal) {
  return select(cloud, staying(removal, nullptr));
}

}  // namespace qs
