// SPDX-License-Identifier: MIT
//
// Heat maps drawn over a frame: listed pairs, evaluated pairs, false positives, missed
// contributions, levels of detail or their errors. A legend strip below shows the scale, its unit,
// the mode and the total. To add a quantity of a frame: a row in kHeatmaps, and its values in
// make_heatmap().
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "app/picture/legend.h"
#include "app/picture/palette.h"
#include "raster/api/renderer.h"

namespace qs {

enum class HeatQuantity { pairs, evaluated, false_positive, missed, level, error };

struct HeatmapRow {
  const char* name;   ///< the name that users type
  const char* title;  ///< fmt string, {0} = side of a cell in pixels
  const char* unit;   ///< one of them
  const char* cell;   ///< "tile" or "pixel"
};

/// Index = HeatQuantity. One frame determines a quantity up to false_positive, see
/// inspect/heatmap_frame.h.
inline constexpr std::array kHeatmaps = {
    HeatmapRow{"pairs", "Tile pairs per {0} \u00d7 {0} tile", "pair", "tile"},
    HeatmapRow{"evaluated", "Evaluated pairs per pixel", "pair", "pixel"},
    HeatmapRow{"false-positive",
               "False positives per {0} \u00d7 {0} tile: pairs that no pixel used", "pair", "tile"},
    HeatmapRow{"missed", "Missed contributions per pixel: what the mode drops", "contribution",
               "pixel"},
    HeatmapRow{"level", "Level of detail per pixel: log2 of the Gaussians of a node", "level",
               "pixel"},
    HeatmapRow{"error", "Estimated error per pixel, in steps of 1/255", "step", "pixel"},
};
inline constexpr std::size_t kHeatQuantities = kHeatmaps.size();

constexpr const HeatmapRow& heatmap_row(HeatQuantity quantity) {
  return kHeatmaps[static_cast<std::size_t>(quantity)];
}

/// The names of all quantities. Index = HeatQuantity.
std::vector<std::string> heatmap_names();

struct Heatmap {
  HeatQuantity quantity = HeatQuantity::pairs;
  int columns = 0, rows = 0;  ///< cells
  int cell_px = 1;            ///< side of a cell; the last cells may extend beyond the picture
  std::vector<std::uint32_t> values;  ///< rows * columns
  std::uint64_t total = 0;
  std::uint64_t whole = 0;  ///< a number other than 0: the legend prints `total` as a share of it
  std::uint32_t largest = 0;
  bool is_of_faces = false;  ///< of a lens: sums over its faces, or values of their pixels
};

/// Sets `total` and `largest` from the values.
void sum_up(Heatmap& map);

constexpr bool takes_one_frame(HeatQuantity quantity) {
  return quantity <= HeatQuantity::false_positive;
}

/// The outputs that make_heatmap() needs; none for quantities that take more than one frame.
Outputs outputs_for(HeatQuantity quantity);

/// `frame` has width x height pixels and was rendered with outputs_for(quantity).
Heatmap make_heatmap(const Frame& frame, HeatQuantity quantity, int width, int height);

/// The tile pairs of one frame minus the tile pairs of another frame of the same view.
struct PairDifference {
  TileGrid grid;
  std::vector<std::int32_t> values;  ///< one value per tile
  std::int64_t total = 0;
};

/// `a` and `b` are Frame::pairs of frames with this grid.
PairDifference pair_difference(const TileGrid& grid, std::span<const std::uint32_t> a,
                               std::span<const std::uint32_t> b);

Legend make_legend(const Heatmap& heatmap, const Scale& scale, const char* mode,
                   HeatColors colors = HeatColors::viridis);

/// The picture with the map over it.
Image draw_over(const Image& color, const Heatmap& heatmap, const Scale& scale,
                const HeatStyle& style = {});

/// draw_over() with the legend strip below it. The width stays.
Image draw_heatmap(const Image& color, const Heatmap& heatmap, const Scale& scale, const char* mode,
                   const HeatStyle& style = {});

}  // namespace qs
