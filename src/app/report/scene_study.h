// SPDX-License-Identifier: MIT
//
// What a scene's views cost and why: which Gaussians are visible, which of them bring the savings
// of each mode, what becomes of the pairs, how evenly tiles are loaded, and all of it for other
// tile sizes. Plain sums over views; page and plots are made of them elsewhere.
// To add a quantity by which Gaussians are sorted: a row of kQuantities.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "app/inspect/gaussian.h"
#include "app/inspect/pair_use.h"

namespace qs {

/// Something that a visible Gaussian has more or less of. Bins lie between neighbouring edges; the
/// first and the last one also take what lies beyond.
struct Quantity {
  const char* name;   ///< for titles
  const char* key;    ///< for file names
  const char* unit;   ///< "" for a plain number
  const char* means;  ///< one sentence for readers
  std::array<double, 13> edges;
  double (*of)(const Footprint& footprint, const Splat& splat);
};

std::span<const Quantity> quantities();
inline constexpr std::size_t kBins = 12;
inline constexpr std::size_t kUsualSize = 1;  ///< index of kTileSize in kTileSizes

/// Index of the bin that `value` falls into.
std::size_t bin_of(const Quantity& quantity, double value);

/// The visible Gaussians in the bins of one quantity.
struct BinnedPairs {
  std::array<std::uint64_t, kBins> gaussians{};
  /// Pairs of the bin's Gaussians, index = CullMode - 1.
  std::array<std::array<std::uint64_t, kBins>, kCullerCount> pairs{};
};

/// A mode at one tile size.
struct ModeStudy {
  std::uint64_t pairs = 0;  ///< as the renderer counts them
  PairUses uses;
  std::vector<std::uint32_t> loads;  ///< list lengths of all tiles of all views, ascending
};

struct SceneStudy {
  std::size_t views = 0;
  std::uint64_t gaussians = 0;      ///< in the cloud
  std::uint64_t visible = 0;        ///< in mode 3dgs, summed over the views
  std::vector<BinnedPairs> binned;  ///< parallel to quantities()
  std::array<std::array<ModeStudy, kCullerCount>, kTileSizes.size()> modes;  ///< [size][mode - 1]
  /// The Gaussian on which `quadbox` saves most against `adr`, of those whose boxes lie inside the
  /// picture and have room in a drawing.
  struct Telling {
    std::size_t view = 0;
    std::uint32_t gaussian = 0;
    std::array<std::uint32_t, kCullerCount> pairs{};  ///< index = CullMode - 1
    std::uint32_t saved = 0;                          ///< 0: there is none
  } telling;
};

/// Renders every mode of every view on a CPU renderer that has the scene. `settings`: mode and tile
/// size do not matter. Throws Cancelled.
SceneStudy study_scene(Renderer& cpu, std::span<const Camera> views, RenderSettings settings,
                       ThreadPool& pool, const Progress& progress);

}  // namespace qs
