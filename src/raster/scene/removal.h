// SPDX-License-Identifier: MIT
//
// Finds the Gaussians of a cloud that a crop box and a search for floaters remove. The result does
// not depend on threads or chance; the time is n log n in the number of Gaussians.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vector_relational.hpp>

#include "base/progress.h"
#include "raster/scene/gaussian_cloud.h"
#include "raster/scene/gaussian_set.h"

namespace qs {

/// A box along the axes of the cloud in memory (RDF), world units; low <= high. Centres on its
/// border are inside.
struct CropBox {
  glm::vec3 low{0.0f}, high{0.0f};
  bool contains(glm::vec3 p) const {
    return glm::all(glm::lessThanEqual(low, p)) && glm::all(glm::lessThanEqual(p, high));
  }
  bool operator==(const CropBox&) const = default;
};

/// Criteria of floaters, which can be switched off one by one.
struct Floaters {
  bool faint = true, large = true, isolated = true;
  float least_opacity = 0.02f;  ///< 0..1: fainter Gaussians are removed
  /// Gaussians with a longer standard deviation are removed. A factor on the longest side of the
  /// box that holds the middle 90 % of the centres per axis.
  float largest_size = 0.5f;
  /// Gaussians with fewer neighbours are removed. Neighbours are in the 27 cells around the centre.
  /// The cells of a CellGrid; larger Gaussians use grids with cells 4, 16, ... times as long.
  int fewest_neighbours = 8;

  bool operator==(const Floaters&) const = default;
};

/// The reason why a Gaussian is removed: the first that applies.
enum class Removed : std::uint8_t { no, outside, faint, large, isolated, selected };
inline constexpr std::size_t kRemovedReasons = 6;

struct RemovalCounts {
  std::array<std::size_t, kRemovedReasons> counts{};  ///< index = Removed
  std::size_t all() const { return std::accumulate(counts.begin(), counts.end(), std::size_t{0}); }
  std::size_t staying() const { return counts[static_cast<std::size_t>(Removed::no)]; }
  std::size_t going() const { return all() - staying(); }
  /// So many of the Gaussians that stay are selected by the user.
  void add_selected(std::size_t selected) {
    counts[static_cast<std::size_t>(Removed::no)] -= selected;
    counts[static_cast<std::size_t>(Removed::selected)] += selected;
  }
  bool operator==(const RemovalCounts&) const = default;
};

struct Removal : RemovalCounts {
  std::vector<Removed> marks;  ///< per Gaussian

  /// The marked Gaussians.
  GaussianSet gone(ThreadPool& pool) const {
    return GaussianSet::where(marks.size(), pool,
                              [&](std::size_t i) { return marks[i] != Removed::no; });
  }
};

/// Floaters are searched among the Gaussians in the box, and sizes and neighbours refer to those
/// Gaussians only. Values that are not numbers fail every criterion. Only the
/// Gaussians of `among` are searched, marked and counted; null: all. Throws Cancelled.
Removal find_removal(const GaussianCloud& cloud, const std::optional<CropBox>& box,
                     const std::optional<Floaters>& floaters, const Progress& progress = {},
                     const GaussianSet* among = nullptr);

/// The Gaussians that stay, in their order. `removal` is of this cloud.
GaussianCloud keep_rest(const GaussianCloud& cloud, const Removal& removal);

}  // namespace qs
