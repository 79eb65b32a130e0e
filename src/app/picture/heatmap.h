// SPDX-License-Identifier: MIT
//
// What a frame cost, drawn over the frame, with a legend strip below it that prints the scale, its
// unit, the mode and the total. The total of the map `pairs` is the frame's tile pairs. To add a
// quantity: a row of kHeatmaps, and its values in make_heatmap().
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "app/picture/scale.h"
#include "raster/renderer.h"

namespace qs {

enum class HeatQuantity { pairs, evaluated };

struct HeatmapRow {
  const char* name;   ///< as users type it
  const char* title;  ///< with the cell it counts in
  const char* unit;
  const char* cell;
};

/// Index = HeatQuantity. UTF-8: the multiplication sign.
inline constexpr std::array kHeatmaps = {
    HeatmapRow{"pairs", "Tile pairs per 16 \u00d7 16 tile", "pairs", "tile"},
    HeatmapRow{"evaluated", "Evaluated pairs per pixel", "pairs", "pixel"},
};

struct Heatmap {
  HeatQuantity quantity = HeatQuantity::pairs;
  int columns = 0, rows = 0;  ///< cells
  int cell_px = 1;            ///< side of a cell; the last ones may reach beyond the picture
  std::vector<std::uint32_t> values;  ///< rows * columns
  std::uint64_t total = 0;
  std::uint32_t largest = 0;
};

/// What render() must be asked for.
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
