// SPDX-License-Identifier: MIT
//
// The other side of a split window, and the differences of both.
#include <fmt/format.h>

#include "app/viewer/panel_model/panel_model.h"
#include "app/viewer/state/hud_text.h"

namespace qs {
namespace {

// The value of the map of pair differences under the cursor; pages do not follow it.
std::string pairs_here(const Viewer& v) {
  if (v.is_remote) return "";
  const PairDifference& pairs = *v.shown.other->pairs;
  const auto tile = cell_under_cursor(v, pairs.grid.tile_px * v.shown.divisor, pairs.grid.columns,
                                      pairs.grid.rows);
  return "; here: " + (tile ? signed_text(pairs.values[*tile]) : "-");
}

void add_differences(const Viewer& v, Blocks& blocks) {
  const ShownOther& other = *v.shown.other;
  const SplitView view = v.split.view;
  if (view == SplitView::tile_pairs && other.pairs) {
    blocks.push_back(block::ColorBar{pair_legend(v.shown)});
    blocks.push_back(
        block::Text{"blue: the first lists fewer, orange: more" + pairs_here(v), Tone::faint});
  }
  if (view == SplitView::difference)
    blocks.push_back(block::ColorBar{difference_legend(shown_amplification(v))});
  // The window has them in its legend over the picture.
  const bool has_maps = view == SplitView::sides || view == SplitView::whole;
  if (v.is_remote && has_maps && v.shown.heatmap && other.heatmap)
    blocks.push_back(block::Text{heat_facts(v), Tone::faint});
  blocks.push_back(block::Facts{split_facts(v)});
}

}  // namespace

Blocks split_blocks(const Viewer& v) {
  Blocks blocks;
  if (v.beside) {
    const auto [first, second] = names_of_scenes(v, *v.beside);
    blocks.push_back(
        block::Text{fmt::format("{} beside {}, both {}", first, second, full_name(v.variant()))});
    blocks.push_back(in_line({{"Close the scene beside"}}));
  } else {
    const std::string beside = name_beside(v.variant(), v.split.other) + " beside";
    blocks.push_back(block::Controls{{{"beside", 10, false, {}, beside}, {"drawn by", 10}}});
  }
  block::Controls controls = {{{"view", 0, false, block::Form::radio}, {"differences times", 9}}};
  if (v.is_remote) controls.controls.push_back({"divider"});
  controls.controls.push_back({"Flip"});
  blocks.emplace_back(controls);
  blocks.push_back(block::Line{});
  if (v.shown.other && !v.shows_grid) {
    add_differences(v, blocks);
  } else if (v.split.other.mode == kReferenceMode) {
    blocks.push_back(
        block::Text{"0 computes the reference of this view, which takes seconds; Shift+0 only what "
                    "is around the cursor."});
  }
  return blocks;
}

std::optional<std::size_t> cell_under_cursor(const Viewer& viewer, int cell_px, int columns,
                                             int rows) {
  const glm::dvec2 cursor = viewer.cursor;
  const glm::ivec2 at = glm::ivec2(glm::floor(cursor)) / std::max(cell_px, 1);
  if (cursor.x < 0 || cursor.y < 0 || at.x >= columns || at.y >= rows) return std::nullopt;
  return static_cast<std::size_t>(at.y * columns + at.x);
}

}  // namespace qs
