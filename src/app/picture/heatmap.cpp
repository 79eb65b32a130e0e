// SPDX-License-Identifier: MIT
#include "app/picture/heatmap.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/list_of.h"
#include "base/text.h"

namespace qs {
namespace {

float gray(const Image& image, int x, int y) {
  const float value =
      0.299f * image.at(x, y, 0) + 0.587f * image.at(x, y, 1) + 0.114f * image.at(x, y, 2);
  return std::clamp(value, 0.0f, 1.0f);
}

// Side of the blocks in which the frame's contrast is drawn: cells if these are tiles, else tiles.
int block_px(const Heatmap& heatmap) { return heatmap.cell_px > 1 ? heatmap.cell_px : kTileSize; }

// The frame is drawn as its difference from the block's mean gray, so that the mean colour of a
// block is the colour of the scale. Cells with the value 0 show the frame, dimmed.
void draw_block(Image& result, const Image& color, const Heatmap& heatmap, const Scale& scale,
                const HeatStyle& style, glm::ivec2 corner) {
  const int right = std::min(corner.x + block_px(heatmap), color.width);
  const int bottom = std::min(corner.y + block_px(heatmap), color.height);
  float mean = 0;
  for (int y = corner.y; y < bottom; ++y)
    for (int x = corner.x; x < right; ++x) mean += gray(color, x, y);
  mean /= static_cast<float>((right - corner.x) * (bottom - corner.y));
  for (int y = corner.y; y < bottom; ++y) {
    for (int x = corner.x; x < right; ++x) {
      const int cell = y / heatmap.cell_px * heatmap.columns + x / heatmap.cell_px;
      const std::uint32_t value = heatmap.values[static_cast<std::size_t>(cell)];
      const float light = gray(color, x, y);
      const float t = static_cast<float>(value) / static_cast<float>(scale.maximum);
      const glm::vec3 shown =
          value == 0 ? heat_of_zero(light) : with_detail(heat(t, style.colors), light - mean);
      for (int c = 0; c < 3; ++c)
        result.at(x, y, c) = style.opacity * shown[c] + (1 - style.opacity) * color.at(x, y, c);
    }
  }
}

}  // namespace

std::vector<std::string> heatmap_names() {
  return list_of<std::string>(kHeatmaps, &HeatmapRow::name);
}

Outputs outputs_for(HeatQuantity quantity) {
  const bool used = quantity == HeatQuantity::false_positive;
  return {.pairs = used || quantity == HeatQuantity::pairs,
          .evaluated = quantity == HeatQuantity::evaluated,
          .used = used};
}

void sum_up(Heatmap& map) {
  map.total = sum_of(map.values);
  map.largest = map.values.empty() ? 0 : std::ranges::max(map.values);
}

Heatmap make_heatmap(const Frame& frame, HeatQuantity quantity, int width, int height) {
  const TileGrid& grid = frame.grid;
  Heatmap map = quantity == HeatQuantity::evaluated
                    ? Heatmap{quantity, width, height, 1, frame.evaluated}
                    : Heatmap{quantity, grid.columns, grid.rows, grid.tile_px, frame.pairs};
  if (quantity == HeatQuantity::false_positive) {
    map.whole = frame.stats.tile_pairs;
    for (std::size_t tile = 0; tile < map.values.size(); ++tile)
      map.values[tile] -= frame.used[tile];
  }
  sum_up(map);
  return map;
}

PairDifference pair_difference(const TileGrid& grid, std::span<const std::uint32_t> a,
                               std::span<const std::uint32_t> b) {
  PairDifference result{grid, {}, 0};
  for (std::size_t tile = 0; tile < a.size(); ++tile) {
    result.values.push_back(static_cast<std::int32_t>(std::int64_t{a[tile]} - b[tile]));
    result.total += result.values.back();
  }
  return result;
}

Legend make_legend(const Heatmap& heatmap, const Scale& scale, const char* mode,
                   HeatColors colors) {
  const HeatmapRow& row = heatmap_row(heatmap.quantity);
  Legend legend;
  legend.title = fmt::format(fmt::runtime(row.title), heatmap.cell_px);
  if (heatmap.is_of_faces)
    legend.title += heatmap.cell_px > 1 ? ", sums over the faces of the lens"
                                        : ", of the nearest pixel of a face of the lens";
  const std::string share = heatmap.whole == 0
                                ? ""
                                : fmt::format(", {:.1f} % of {}",
                                              100 * static_cast<double>(heatmap.total) /
                                                  static_cast<double>(heatmap.whole),
                                              grouped(heatmap.whole));
  const std::string sum =  // of counts
      heatmap.quantity > HeatQuantity::missed
          ? ""
          : fmt::format("{} in all{} \u00b7 ", counted(heatmap.total, row.unit), share);
  legend.facts = fmt::format("mode {} \u00b7 {}at most {} in a {}", mode, sum,
                             grouped(heatmap.largest), row.cell);
  const auto maximum = static_cast<float>(scale.maximum);
  for (const std::uint32_t tick : scale.ticks())
    legend.ticks.push_back({static_cast<float>(tick) / maximum, grouped(tick)});
  // The plus sign shows that larger values have the last colour too. The title has the unit.
  if (heatmap.largest > scale.maximum) legend.ticks.back().text += "+";
  legend.zero = heat_of_zero(0.5f);
  legend.color = [maximum, colors](float t) {
    return t * maximum < 0.5f ? heat_of_zero(0.5f) : heat(t, colors);
  };
  return legend;
}

Image draw_over(const Image& color, const Heatmap& heatmap, const Scale& scale,
                const HeatStyle& style) {
  Image result(color.width, color.height, 3);
  for (int top = 0; top < color.height; top += block_px(heatmap))
    for (int left = 0; left < color.width; left += block_px(heatmap))
      draw_block(result, color, heatmap, scale, style, {left, top});
  return result;
}

Image draw_heatmap(const Image& color, const Heatmap& heatmap, const Scale& scale, const char* mode,
                   const HeatStyle& style) {
  return with_legend(draw_over(color, heatmap, scale, style),
                     make_legend(heatmap, scale, mode, style.colors));
}

}  // namespace qs
