// SPDX-License-Identifier: MIT
//
// What a frame cost, wasted or lost, drawn over the frame, with a legend strip below it that prints
// the scale, its unit, the mode and the total. The total of the map `pairs` is the frame's tile
// pairs. To add a quantity of a frame: a row of kHeatmaps, and its values in make_heatmap().
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "app/picture/scale.h"
#include "raster/renderer.h"

namespace qs {

enum class HeatQuantity { pairs, evaluated, false_positive, missed };

struct HeatmapRow {
  const char* name;   ///< as users type it
  const char* title;  ///< with the cell it counts in, {0} = its side in pixels
  const char* unit;
  const char* cell;
};

/// What a frame tells by itself. Index = HeatQuantity. UTF-8: the multiplication sign.
inline constexpr std::array kHeatmaps = {
    HeatmapRow{"pairs", "Tile pairs per {0} \u00d7 {0} tile", "pairs", "tile"},
    HeatmapRow{"evaluated", "Evaluated pairs per pixel", "pairs", "pixel"},
    HeatmapRow{"false-positive",
               "False positives per {0} \u00d7 {0} tile: pairs that no pixel used", "pairs",
               "tile"},
};

/// HeatQuantity::missed takes another frame to judge by, see inspect/missed.h.
inline constexpr HeatmapRow kMissedHeatmap{
    "missed", "Missed contributions per pixel: what the mode drops", "contributions", "pixel"};

/// All of them, the missed contributions too.
inline constexpr std::size_t kHeatQuantities = kHeatmaps.size() + 1;

inline const HeatmapRow& heatmap_row(HeatQuantity quantity) {
  const auto index = static_cast<std::size_t>(quantity);
  return index < kHeatmaps.size() ? kHeatmaps[index] : kMissedHeatmap;
}

struct Heatmap {
  HeatQuantity quantity = HeatQuantity::pairs;
  int columns = 0, rows = 0;  ///< cells
  int cell_px = 1;            ///< side of a cell; the last ones may reach beyond the picture
  std::vector<std::uint32_t> values;  ///< rows * columns
  std::uint64_t total = 0;
  std::uint64_t whole = 0;  ///< what the total is a share of, 0 when of nothing
  std::uint32_t largest = 0;
};

/// Sets total and largest from the values.
void sum_up(Heatmap& map);

/// What render() must be asked for; `quantity` is one of kHeatmaps.
Outputs outputs_for(HeatQuantity quantity);

/// From a frame rendered with outputs_for(quantity) at width x height.
Heatmap make_heatmap(const Frame& frame, HeatQuantity quantity, int width, int height);

/// The words of a legend, apart from its drawing.
struct Legend {
  std::string title, facts;
  std::vector<std::string> ticks;  ///< parallel to Scale::ticks()
};
Legend make_legend(const Heatmap& heatmap, const Scale& scale, const char* mode);

/// The picture with the map over it and the legend strip below: same width, more rows.
Image draw_heatmap(const Image& color, const Heatmap& heatmap, const Scale& scale,
                   const char* mode);

}  // namespace qs
