// SPDX-License-Identifier: MIT
#include "raster/scene/removal.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "base/rank.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/cloud_order.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {
namespace {

using Numbers = std::vector<std::uint32_t>;

// ln of the longest standard deviation; NaN if a value is NaN.
float log_size(const GaussianCloud& cloud, std::size_t i) {
  const glm::vec3& s = cloud.log_scales[i];
  return std::isnan(s.x + s.y + s.z) ? std::numeric_limits<float>::quiet_NaN()
                                     : std::max({s.x, s.y, s.z});
}

// value_of(i) of the Gaussians, without values that are not finite.
template <class ValueOf>
std::vector<float> finite_values(const Numbers& of, const ValueOf& value_of) {
  std::vector<float> values;
  values.reserve(of.size());
  for (const std::uint32_t i : of)
    if (const float value = value_of(i); std::isfinite(value)) values.push_back(value);
  return values;
}

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

// ---- the grids ---------------------------------------------------------------------------------
// Keys number cells by z, then y, then x, so that neighbours along x follow each other.
constexpr int kFieldBits = 21, kFinerBits = 2;
constexpr std::int64_t kMiddle = std::int64_t{1} << (kFieldBits - 1), kLast = 2 * kMiddle - 4;
constexpr std::uint64_t kField = (std::uint64_t{1} << kFieldBits) - 1;
constexpr int kLevels = 8;

// Coordinates are stored from 1 on, so that every cell has all its neighbours.
std::uint64_t key_of(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  return (z + 1) << (2 * kFieldBits) | (y + 1) << kFieldBits | (x + 1);
}

std::uint64_t coarser(std::uint64_t key) {
  const auto field = [key](int n) { return ((key >> (n * kFieldBits)) & kField) - 1; };
  return key_of(field(0) >> kFinerBits, field(1) >> kFinerBits, field(2) >> kFinerBits);
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
      // Wraps around for negative steps, as unsigned numbers do.
      const std::uint64_t step = (static_cast<std::uint64_t>(dz) << (2 * kFieldBits)) +
                                 (static_cast<std::uint64_t>(dy) << kFieldBits);
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

struct Grid {
  glm::dvec3 middle{0.0};
  double cell = 0;  ///< length, > 0

  std::optional<std::uint64_t> key(glm::vec3 position) const {
    if (!is_finite(position)) return std::nullopt;
    const glm::dvec3 at = glm::floor((glm::dvec3(position) - middle) / cell);
    std::uint64_t fields[3];
    for (int axis = 0; axis < 3; ++axis) {
      // Gaussians farther out are counted in the border's cells.
      const double clamped = std::clamp(at[axis], -double{kMiddle}, double{kLast - kMiddle});
      fields[axis] = static_cast<std::uint64_t>(static_cast<std::int64_t>(clamped) + kMiddle);
    }
    return key_of(fields[0], fields[1], fields[2]);
  }
};

Numbers isolated(const GaussianCloud& cloud, const Numbers& of, int fewest_neighbours,
                 const Progress& progress) {
  Numbers found;
  if (of.empty() || fewest_neighbours <= 0) return found;
  // Lay a grid around the middle, with cells of a multiple of the median size.
  auto sizes = finite_values(of, [&](std::uint32_t i) { return log_size(cloud, i); });
  if (sizes.empty()) return found;
  const float median = quantile(sizes, 0.5);
  const double cell = double{Floaters::kCellSigmas} * std::exp(double{median});
  if (!(cell > 0) || !std::isfinite(cell)) return found;
  glm::dvec3 middle(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    auto values = finite_values(of, [&](std::uint32_t i) {
      const glm::vec3& p = cloud.positions[i];
      return is_finite(p) ? p[axis] : std::numeric_limits<float>::infinity();
    });
    if (!values.empty()) middle[axis] = double{quantile(values, 0.5)};
  }
  const Grid grid{middle, cell};

  // Count Gaussians per cell. A large Gaussian is looked up in a coarser grid.
  std::vector<Cell> cells;
  cells.reserve(of.size());
  std::array<Numbers, kLevels> of_level;
  for (const std::uint32_t i : of) {
    const auto key = grid.key(cloud.positions[i]);
    if (!key) {
      found.push_back(i);
      continue;
    }
    cells.push_back({*key, 1});
    const double larger = double{log_size(cloud, i)} - double{median};  // NaN: the finest grid
    const double level = larger > 0 ? std::ceil(larger / std::log(1 << kFinerBits)) : 0;
    of_level[static_cast<std::size_t>(std::min(level, kLevels - 1.0))].push_back(i);
  }
  // From fine to coarse, find the Gaussians in cells with too few neighbours.
  for (int level = 0; level < kLevels; ++level) {
    if (level > 0)
      for (Cell& each : cells) each.key = coarser(each.key);
    progress.update(static_cast<float>(level) / static_cast<float>(kLevels));
    cells = merged(std::move(cells));
    const Numbers& here = of_level[static_cast<std::size_t>(level)];
    if (here.empty()) continue;
    const auto lonely = lonely_cells(cells, static_cast<std::uint64_t>(fewest_neighbours));
    if (lonely.empty()) break;  // then no cell of a coarser grid is lonely
    for (const std::uint32_t i : here) {
      std::uint64_t key = *grid.key(cloud.positions[i]);
      for (int coarse = 0; coarse < level; ++coarse) key = coarser(key);
      if (std::ranges::binary_search(lonely, key)) found.push_back(i);
    }
  }
  return found;
}

// The Gaussians that stay, in their order.
Numbers staying(const Removal& removal) {
  Numbers numbers;
  numbers.reserve(removal.marks.size());
  for (std::size_t i = 0; i < removal.marks.size(); ++i)
    if (removal.marks[i] == Removed::no) numbers.push_back(static_cast<std::uint32_t>(i));
  return numbers;
}

}  // namespace

Removal find_removal(const GaussianCloud& cloud, const std::optional<CropBox>& box,
                     const std::optional<Floaters>& floaters, const Progress& progress) {
  Removal removal;
  removal.marks.assign(cloud.size(), Removed::no);
  // Mark Gaussians outside of the box.
  if (box)
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (!box->contains(cloud.positions[i])) removal.marks[i] = Removed::outside;
  // Mark floaters among the rest.
  if (floaters) {
    const Numbers inside = staying(removal);
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
           isolated(cloud, staying(removal), floaters->fewest_neighbours, progress))
        removal.marks[i] = Removed::isolated;
  }
  for (const Removed mark : removal.marks) ++removal.counts[static_cast<std::size_t>(mark)];
  return removal;
}

GaussianCloud keep_rest(const GaussianCloud& cloud, const Removal& removal) {
  return select(cloud, staying(removal));
}

}  // namespace qs
