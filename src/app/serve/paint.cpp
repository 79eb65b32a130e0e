// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <utility>

#include "app/picture/heatmap.h"
#include "app/serve/pictures.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/state/samples.h"

namespace qs {
namespace {

// The frame with a map over it, or as it is.
std::vector<std::uint8_t> with_map(const std::vector<std::uint8_t>& rgba, glm::ivec2 size,
                                   const std::optional<Heatmap>& map, const Scale& scale,
                                   const HeatStyle& style) {
  if (!map) return rgba;
  return to_rgba(draw_over(image_of(rgba, size.x, size.y), *map, scale, style));
}

void draw_difference(std::vector<std::uint8_t>& rgba, const std::vector<std::uint8_t>& other,
                     int amplification) {
  for (std::size_t i = 0; i < rgba.size(); ++i) {
    const int apart = std::abs(int{rgba[i]} - int{other[i]});
    rgba[i] = i % 4 == 3 ? std::uint8_t{255}
                         : static_cast<std::uint8_t>(std::min(255, amplification * apart));
  }
}

// The tile pairs of the first frame minus the tile pairs of the second.
void draw_pairs(std::vector<std::uint8_t>& rgba, int width, const PairDifference& pairs,
                const Scale& scale) {
  const int side = pairs.grid.tile_px;
  for (std::size_t i = 0; i < rgba.size() / 4; ++i) {
    const int x = static_cast<int>(i) % width / side, y = static_cast<int>(i) / width / side;
    const std::int32_t value = pairs.values[static_cast<std::size_t>(y * pairs.grid.columns + x)];
    const glm::vec3 color =
        diverging(static_cast<float>(value) / static_cast<float>(scale.maximum));
    for (int c = 0; c < 3; ++c) rgba[4 * i + static_cast<std::size_t>(c)] = to_8bit(color[c]);
  }
}

std::vector<std::uint8_t> both(const Split& split, const HeatStyle& style, RenderedFrame& frame) {
  const ShownFrame& shown = frame.shown;
  const ShownOther& other = *shown.other;
  std::vector<std::uint8_t> rgba = std::move(frame.rgba);
  if (split.view == SplitView::difference) {
    draw_difference(
        rgba, frame.other,
        split.amplification > 0 ? split.amplification : visible_amplification(other.pixels));
    return rgba;
  }
  if (split.view == SplitView::tile_pairs) {
    if (other.pairs) draw_pairs(rgba, frame.width, *other.pairs, other.pairs_scale);
    return rgba;
  }
  const glm::ivec2 size(frame.width, frame.height);
  std::vector<std::uint8_t> left = with_map(rgba, size, shown.heatmap, shown.map_scale, style);
  std::vector<std::uint8_t> right =
      with_map(frame.other, size, other.heatmap, shown.map_scale, style);
  if (split.flipped) std::swap(left, right);
  if (split.view == SplitView::whole) return left;
  const float edge = std::clamp(split.divider, 0.0f, 1.0f) * static_cast<float>(frame.width);
  const auto x = static_cast<std::size_t>(std::lround(edge));
  const std::size_t row = 4 * static_cast<std::size_t>(frame.width);
  for (std::size_t at = 0; at < left.size(); at += row)
    std::copy(right.begin() + static_cast<std::ptrdiff_t>(at + 4 * x),
              right.begin() + static_cast<std::ptrdiff_t>(at + row),
              left.begin() + static_cast<std::ptrdiff_t>(at + 4 * x));
  return left;
}

}  // namespace

std::vector<std::uint8_t> painted(const FrameRequest& request, const std::optional<Split>& split,
                                  RenderedFrame frame) {
  const ShownFrame& shown = frame.shown;
  if (shown.grid) return std::move(frame.rgba);
  const glm::ivec2 size(frame.width, frame.height);
  const bool beside = split && shown.other;
  if (!beside && !shown.heatmap && !shown.values) return std::move(frame.rgba);
  std::vector<std::uint8_t> rgba =
      beside ? both(*split, request.heat_style, frame)
             : with_map(frame.rgba, size, shown.heatmap, shown.map_scale, request.heat_style);
  const bool has_map =
      !beside || split->view == SplitView::sides || split->view == SplitView::whole;
  if (!has_map || (!shown.heatmap && !shown.values)) return rgba;
  Image image = image_of(rgba, size.x, size.y);
  const char* const mode = mode_name(shown.mode);
  Legend legend =
      shown.heatmap ? make_legend(*shown.heatmap, shown.map_scale, mode, request.heat_style.colors)
                    : make_legend(*shown.values, mode);
  legend.title += size_text(shown.divisor);
  if (beside) legend.facts.clear();  // they are of one side
  draw_legend_over(image, legend);
  return to_rgba(image);
}

}  // namespace qs
