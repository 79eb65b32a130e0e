// SPDX-License-Identifier: MIT
//
// The inspector: the Gaussians of the clicked pixel, front to back, and the tiles of every mode for
// one of them.
#include <algorithm>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "app/inspect/construction.h"
#include "app/viewer/panel_model/panel_model.h"

namespace qs {
namespace {

constexpr const char* kContributionColumns[] = {"Gaussian", "depth",  "alpha",
                                                "in front", "weight", "colour"};
constexpr const char* kTileColumns[] = {"tiles of", "listed", "used", "hidden", "empty"};
constexpr Ink kEllipseInk{kVermillion, kVermillion};

// The mode whose tiles are drawn: `mode` if it is one of the paper's, else the default.
CullMode inspected_mode(CullMode mode) {
  return mode >= 1 && mode <= culler_count() ? mode : default_mode();
}

// The meaning of the colours of its tiles.
std::string construction_text(CullMode mode) {
  return fmt::format(
      "Tiles of {}: strong where a pixel uses the pair, medium where it reaches only pixels that "
      "have stopped, pale where it reaches none.",
      mode_name(inspected_mode(mode)));
}

// The light that is left behind each Gaussian.
block::Chart transmittance_chart(const PixelReport& pixel) {
  const std::vector<Contribution>& list = pixel.contributions;
  block::Chart chart{
      .axis = "transmittance, from front to back", .up = {{0, "0"}, {1, "1"}}, .letters = 7};
  block::Curve curve{.ink = {on_dark::kText, on_white::kInk}, .is_marked = false, .width = 1.5f};
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto count = static_cast<double>(list.size()), at = static_cast<double>(i);
    const double begin = at / count, end = (at + 1) / count;
    const auto light = static_cast<double>(list[i].transmittance);
    const float after = i + 1 < list.size() ? list[i + 1].transmittance : pixel.transmittance;
    chart.columns.push_back({begin, end, light, glm::clamp(list[i].color, 0.0f, 1.0f)});
    curve.points.insert(curve.points.end(),
                        {{begin, light}, {end, light}, {end, static_cast<double>(after)}});
  }
  chart.curves.push_back(std::move(curve));
  return chart;
}

block::Row contribution_row(const Inspection& inspection, const Contribution& from, bool stops) {
  block::Row row;
  row.is_here = inspection.gaussian && inspection.gaussian->gaussian == from.gaussian;
  row.cells.push_back({.text = fmt::format("{}{}", from.gaussian, stops ? " stops" : ""),
                       .use = Use{"Gaussian", 0, from.gaussian}});
  for (const std::string& text : contribution_cells(from, stops)) row.cells.push_back({text});
  row.cells.push_back({.swatch = glm::clamp(from.color, 0.0f, 1.0f)});
  return row;
}

// Pages get the first of very many Gaussians.
void add_contributions(const Viewer& v, Blocks& blocks) {
  constexpr std::size_t kMostForPages = 300;
  const Inspection& inspection = v.inspected->inspection;
  const PixelReport& pixel = inspection.pixel;
  const std::size_t count = pixel.contributions.size();
  const std::size_t shown = v.is_remote ? std::min(count, kMostForPages) : count;
  block::Table table{.name = "contributions", .most_lines = 12, .version = v.inspections};
  constexpr float kShares[] = {1.4f, 1, 1, 1, 1, 0.8f};
  for (std::size_t i = 0; i < std::size(kContributionColumns); ++i)
    table.columns.push_back(
        {kContributionColumns[i], 0, kShares[i], 0, i == 0 || i + 1 == std::size(kShares)});
  for (std::size_t i = 0; i < shown; ++i)
    table.rows.push_back(contribution_row(inspection, pixel.contributions[i], false));
  if (pixel.stopped_by) table.rows.push_back(contribution_row(inspection, *pixel.stopped_by, true));
  blocks.emplace_back(std::move(table));
  if (shown < count)
    blocks.push_back(
        block::Text{fmt::format("and {} more behind them", count - shown), Tone::faint});
}

block::Shape box_shape(const Box& box, Ink ink, float opacity, float width) {
  return {{box.low, box.high}, ink, opacity, width};
}

void add_grid(const Box& window, const TileGrid& grid, std::vector<block::Shape>& shapes) {
  constexpr Ink kGridInk{glm::vec3(1), glm::vec3(0)};
  const auto side = static_cast<float>(grid.tile_px);
  const glm::vec2 low = glm::max(window.low, glm::vec2(0));
  const glm::vec2 high = glm::min(window.high, side * glm::vec2(grid.columns, grid.rows));
  const auto add = [&](glm::vec2 from, glm::vec2 to) {
    shapes.push_back({{from, to}, kGridInk, 0.14f, 1, false});
  };
  for (float x = low.x; x <= high.x; x += side) add({x, low.y}, {x, high.y});
  for (float y = low.y; y <= high.y; y += side) add({low.x, y}, {high.x, y});
}

void add_boxes(const GaussianReport& gaussian, std::vector<block::Shape>& shapes) {
  shapes.push_back(box_shape(gaussian.square, ink_of(k3dgs), 1, 1.5f));
  if (!gaussian.visible) return;
  shapes.push_back(box_shape(gaussian.adr, ink_of(kAdr), 1, 1.5f));
  for (const Box& box : gaussian.quad_boxes) {
    shapes.push_back(box_shape(box, ink_of(kQuad), 0.12f, 0));
    shapes.push_back(box_shape(box, ink_of(kQuad), 1, 1.5f));
  }
  for (const Box& box : gaussian.dual_boxes)
    shapes.push_back(box_shape(box, ink_of(kDual), 1, 1.5f));
  shapes.push_back({ellipse_of(gaussian.footprint, 96), kEllipseInk, 1, 2, false});
}

// The shape of a Gaussian with the boxes and tiles of the modes, in pixels of the frame.
block::Figure construction_figure(const InspectedView& view, CullMode drawn) {
  constexpr std::size_t kMostTiles = 20000;
  constexpr float kOpacity[] = {0.55f, 0.3f, 0.14f};  // index = PairUse
  constexpr Ink kPixelInk{rgb(0x00C88C), rgb(0x00C88C)};
  const GaussianReport& gaussian = *view.inspection.gaussian;
  const Box window = window_of(gaussian, view.grid);
  block::Figure figure{construction_text(drawn), window.low, window.high, {}};
  const auto index = static_cast<std::size_t>(drawn - 1);
  const ModeTiles& listed = gaussian.modes[index];
  for (std::size_t i = 0; i < std::min(listed.tiles.size(), kMostTiles); ++i) {
    const auto use = static_cast<std::size_t>(view.inspection.uses[index][i]);
    figure.shapes.push_back(
        box_shape(box_of_tile(view.grid, listed.tiles[i]), ink_of(drawn), kOpacity[use], 0));
  }
  add_grid(window, view.grid, figure.shapes);
  add_boxes(gaussian, figure.shapes);
  const glm::vec2 pixel(view.inspection.pixel.pixel);
  const glm::vec2 extent = window.high - window.low;
  const float half = std::max(0.5f, 0.015f * std::max(extent.x, extent.y));
  figure.shapes.push_back(box_shape({pixel - half, pixel + half}, kPixelInk, 1, 2));
  return figure;
}

void add_construction(const Viewer& v, Blocks& blocks) {
  const Inspection& inspection = v.inspected->inspection;
  const CullMode drawn = inspected_mode(v.mode());
  blocks.emplace_back(construction_figure(*v.inspected, drawn));
  block::Keys keys{{{"alpha = 1/255", kEllipseInk}}};
  for (const CullMode mode : {k3dgs, kAdr, kDual, kQuad})
    keys.keys.push_back({mode_name(mode), ink_of(mode)});
  blocks.emplace_back(std::move(keys));
  blocks.push_back(block::Text{construction_text(drawn), Tone::faint});
  block::Table counts{.name = "tiles"};
  for (const char* title : kTileColumns) counts.columns.push_back({title, 0, 1});
  counts.columns[0].is_left = true;
  for (std::size_t i = 0; i < inspection.gaussian->modes.size(); ++i) {
    const CullMode mode = inspection.gaussian->modes[i].mode;
    const PairUses uses = uses_of(inspection, i);
    block::Row row;
    row.cells.push_back({mode_name(mode)});
    for (const std::uint64_t count : {uses.pairs(), uses.used, uses.hidden, uses.empty})
      row.cells.push_back({fmt::format("{}", count)});
    row.is_here = mode == drawn;
    counts.rows.push_back(std::move(row));
  }
  blocks.emplace_back(std::move(counts));
}

}  // namespace

Blocks inspector_blocks(const Viewer& v) {
  if (!v.inspected) return {block::Text{kNothingInspected}};
  const Inspection& inspection = v.inspected->inspection;
  Blocks blocks = {block::Text{inspected_pixel_text(inspection.pixel)}};
  if (v.inspected->version != v.version)
    blocks.push_back(block::Text{kInspectedEarlier, Tone::caution});
  if (!inspection.pixel.contributions.empty())
    blocks.emplace_back(transmittance_chart(inspection.pixel));
  add_contributions(v, blocks);
  if (inspection.gaussian) add_construction(v, blocks);
  return blocks;
}

}  // namespace qs
