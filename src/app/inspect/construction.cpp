// SPDX-License-Identifier: MIT
#include "app/inspect/construction.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "app/inspect/inspection.h"
#include "app/picture/canvas.h"
#include "app/picture/palette.h"
#include "base/text.h"
#include "raster/kernel/cull/table.h"

namespace qs {
namespace {

using on_white::kFaint;
using on_white::kInk;

constexpr int kWidth = 1800, kMostHeight = 1500, kFigureMargin = 40, kFigureGap = 28,
              kSmallGap = 18;
constexpr glm::ivec2 kMain{860, 640}, kWalk{440, 420};
constexpr int kFacts = kWidth - 2 * kFigureMargin - kMain.x - kWalk.x - 2 * kFigureGap;
constexpr int kModePanel =
    (kWidth - 2 * kFigureMargin - (kCullerCount - 1) * kSmallGap) / kCullerCount;
constexpr int kModePanelHeight = 250;

const Pen kSquarePen{kInk, 2.5f, 1, 9}, kAdrPen{mode_color(kAdr), 3},
    kDualPen{mode_color(kDual), 3}, kQuadPen{mode_color(kQuad), 2.5f}, kEllipsePen{kRed, 2.5f},
    kPixelPen{kGreen, 3};
constexpr float kDualFill = 0.3f, kQuadFill = 0.16f, kEllipseFill = 0.22f;

struct Fonts {
  Font title{38}, head{26}, text{22}, small{19};
};

struct LineStyle {
  const Font& font;
  glm::vec3 color;
  int gap;  ///< pixels below the line
  Align align = Align::left;
};

/// Draws a line of text. Returns the top of the next line.
int write(Image& page, const LineStyle& style, glm::ivec2 at, const std::string& text) {
  draw_text(page, style.font, at, text, style.color, style.align);
  return at.y + style.font.line_height() + style.gap;
}

Image main_panel(const ConstructionInput& input, const Box& window) {
  const GaussianReport& g = *input.inspection.gaussian;
  FrameCanvas panel(window, kMain);
  panel.draw_frame(input.color, 0.3f);
  panel.draw_grid(input.grid, {input.color.width, input.color.height});
  for (const Box& box : g.quad_boxes) panel.fill_box(box, kQuadPen.color, kQuadFill);
  for (const Box& box : g.dual_boxes) panel.fill_box(box, kDualPen.color, kDualFill);
  panel.outline_box(g.square, kSquarePen);
  if (g.visible) {
    panel.outline_box(g.adr, kAdrPen);
    panel.draw_ellipse(g.footprint, kEllipsePen, kEllipseFill);
  }
  for (const Box& box : g.quad_boxes) panel.outline_box(box, kQuadPen);
  for (const Box& box : g.dual_boxes) panel.outline_box(box, kDualPen);
  panel.draw_dot(g.footprint.mean_px, 5, kEllipsePen.color);
  const glm::vec2 pixel(input.inspection.pixel.pixel);
  const float half = std::max(0.5f, 5 / panel.scale());
  panel.outline_box({pixel - half, pixel + half}, kPixelPen);
  return panel.picture();
}

/// The lines of tiles that QPass walks, numbered in order, with the interval of each line.
Image walk_panel(const ConstructionInput& input, const Box& window, const Font& font) {
  const GaussianReport& g = *input.inspection.gaussian;
  const ModeTiles& quad = g.modes[static_cast<std::size_t>(kQuad) - 1];
  FrameCanvas panel(window, kWalk);
  panel.draw_grid(input.grid, {input.color.width, input.color.height});
  for (const Box& box : g.quad_boxes) panel.outline_box(box, {kQuadPen.color, 1.5f, 0.7f});
  if (g.visible) panel.draw_ellipse(g.footprint, {kEllipsePen.color, 1.5f, 0.8f}, 0);
  const auto side = static_cast<float>(input.grid.tile_px);
  const float tick = 0.28f * side;
  int number = 0;
  for (const TileRun& run : quad.runs) {
    ++number;
    if (run.tiles.size() == 0) continue;
    const float v = (static_cast<float>(run.line) + 0.5f) * side;
    const float begin = static_cast<float>(run.tiles.begin) * side + 0.12f * side;
    const float end = static_cast<float>(run.tiles.end) * side - 0.12f * side;
    const auto at = [&](float along, float across) {
      return quad.walks_rows ? glm::vec2(along, across) : glm::vec2(across, along);
    };
    const Pen pen{kQuadPen.color, 3};
    panel.draw_line(at(begin, v), at(end, v), pen);
    panel.draw_line(at(begin, v - tick), at(begin, v + tick), pen);
    panel.draw_line(at(end, v - tick), at(end, v + tick), pen);
    if (side * panel.scale() < static_cast<float>(font.line_height())) continue;
    const glm::vec2 label = panel.to_picture(at(begin - 0.62f * side, v));
    draw_text(panel.picture(), font,
              {static_cast<int>(label.x), static_cast<int>(label.y) - font.line_height() / 2},
              fmt::format("{}", number), kInk, Align::center);
  }
  return panel.picture();
}

/// The tiles that a mode lists, filled by their use. `index` = CullMode - 1.
Image mode_panel(const ConstructionInput& input, const Box& window, std::size_t index) {
  const GaussianReport& g = *input.inspection.gaussian;
  const ModeTiles& mode = g.modes[index];
  const glm::vec3 color = mode_color(mode.mode);
  FrameCanvas panel(window, {kModePanel, kModePanelHeight});
  for (std::size_t i = 0; i < mode.tiles.size(); ++i) {
    constexpr float kOpacity[] = {0.8f, 0.38f, 0.12f};  // index = PairUse
    panel.fill_box(box_of_tile(input.grid, mode.tiles[i]), color,
                   kOpacity[static_cast<int>(input.inspection.uses[index][i])]);
  }
  panel.draw_grid(input.grid, {input.color.width, input.color.height});
  for (const int tile : mode.tiles) panel.outline_box(box_of_tile(input.grid, tile), {color, 1.2f});
  if (g.visible) {
    panel.draw_ellipse(g.footprint, {on_white::kWhite, 4.5f, 0.85f},
                       0);  // for contrast on dark tiles
    panel.draw_ellipse(g.footprint, {kInk, 1.8f}, 0);
  }
  return panel.picture();
}

std::vector<InspectedFact> pixel_facts(const Inspection& inspection) {
  const PixelReport& pixel = inspection.pixel;
  std::vector<InspectedFact> facts = {
      {"listed in its tile", grouped(pixel.listed)},
      {"evaluated", grouped(pixel.evaluated)},
      {"blended", grouped(pixel.contributions.size())},
      {"background weight", fmt::format("{:.2f} %", 100 * pixel.transmittance)}};
  for (const Contribution& c : pixel.contributions) {
    if (c.gaussian != inspection.gaussian->gaussian) continue;
    facts.push_back({"alpha of this one", fmt::format("{:.4f}", c.alpha)});
    facts.push_back({"transmittance before", fmt::format("{:.4f}", c.transmittance)});
    facts.push_back({"weight", fmt::format("{:.4f}", c.weight)});
  }
  return facts;
}

/// Returns the top of the next line.
int draw_facts(Image& page, const Fonts& fonts, glm::ivec2 at, const std::string& title,
               const std::vector<InspectedFact>& facts) {
  int y = write(page, {fonts.head, kInk, 8}, at, title);
  for (const InspectedFact& fact : facts) {
    draw_text(page, fonts.small, {at.x, y}, fact.label, kFaint);
    y = write(page, {fonts.small, kInk, 6, Align::right}, {at.x + kFacts, y}, fact.value);
  }
  return y;
}

/// Returns the bottom of the panels' texts.
int draw_mode_panels(Image& page, const Fonts& fonts, int top, const ConstructionInput& input,
                     const Box& window) {
  int bottom = top;
  for (std::size_t i = 0; i < input.inspection.gaussian->modes.size(); ++i) {
    const Image panel = mode_panel(input, window, i);
    const int center =
        kFigureMargin + static_cast<int>(i) * (kModePanel + kSmallGap) + kModePanel / 2;
    paste(page, panel, {center - panel.width / 2, top});
    const PairUses uses = uses_of(input.inspection, i);
    bottom =
        write(page, {fonts.head, kInk, 4, Align::center}, {center, top + panel.height + 10},
              fmt::format("{}: {} tiles", mode_name(static_cast<CullMode>(i) + 1), uses.pairs()));
    bottom = write(page, {fonts.small, kFaint, 0, Align::center}, {center, bottom},
                   fmt::format("{} used, {} hidden, {} empty", uses.used, uses.hidden, uses.empty));
  }
  return bottom;
}

/// Samples of the lines in the main panel with their meanings. Returns the top of the next line.
int draw_legend(Image& page, const Fonts& fonts, glm::ivec2 at, const GaussianReport& g) {
  struct Entry {
    const Pen& pen;
    float fill;
    std::string words;
  };
  const Entry entries[] = {
      {kEllipsePen, kEllipseFill, "where alpha reaches 1/255"},
      {kSquarePen, 0,
       fmt::format("{}: square of {}", mode_name(k3dgs),
                   g.footprint.is_solid() ? "the longer half axis" : "three sigma")},
      {kAdrPen, 0, fmt::format("{}: bounding box of the ellipse", mode_name(kAdr))},
      {kDualPen, kDualFill, fmt::format("{}: its two major quadrants", mode_name(kDual))},
      {kQuadPen, kQuadFill,
       fmt::format("{}: also the others, {:.2f} times as large", mode_name(kQuad), g.f)},
      {kPixelPen, 0, "the pixel"}};
  for (const Entry& entry : entries) {
    const auto box = corners_of(at + glm::ivec2(0, 5), at + glm::ivec2(34, 19));
    if (entry.fill > 0) fill_polygon(page, box, entry.pen.color, entry.fill);
    stroke(page, box, true, entry.pen);
    at.y = write(page, {fonts.small, kInk, 5}, {at.x + 46, at.y}, entry.words);
  }
  return at.y;
}

}  // namespace

Box box_of_tile(const TileGrid& grid, int tile) {
  const glm::vec2 low =
      static_cast<float>(grid.tile_px) * glm::vec2(tile % grid.columns, tile / grid.columns);
  return {low, low + static_cast<float>(grid.tile_px)};
}

FrameCanvas::FrameCanvas(const Box& window, glm::ivec2 size, float scale_limit) : window_(window) {
  const glm::vec2 extent = window.high - window.low, room(size);
  scale_ = std::min({room.x / extent.x, room.y / extent.y, scale_limit});
  picture_ = plain_picture(static_cast<int>(std::ceil(extent.x * scale_)),
                           static_cast<int>(std::ceil(extent.y * scale_)), on_white::kPanel);
}

void FrameCanvas::draw_frame(const Image& color, float strength) {
  for (int y = 0; y < picture_.height; ++y) {
    for (int x = 0; x < picture_.width; ++x) {
      const glm::vec2 at = glm::floor(window_.low + (glm::vec2(x, y) + 0.5f) / scale_ + 0.5f);
      const glm::ivec2 pixel(at);
      if (pixel.x < 0 || pixel.y < 0 || pixel.x >= color.width || pixel.y >= color.height) continue;
      for (int c = 0; c < 3; ++c) {
        const float value = std::clamp(color.at(pixel.x, pixel.y, c), 0.0f, 1.0f);
        picture_.at(x, y, c) = 1 - strength + strength * value;
      }
    }
  }
}

void FrameCanvas::draw_grid(const TileGrid& grid, glm::vec2 image_size) {
  const auto side = static_cast<float>(grid.tile_px);
  const Pen pen{kGray, 1, 0.55f};
  for (float x = std::ceil(window_.low.x / side) * side; x <= window_.high.x; x += side)
    draw_line({x, window_.low.y}, {x, window_.high.y}, pen);
  for (float y = std::ceil(window_.low.y / side) * side; y <= window_.high.y; y += side)
    draw_line({window_.low.x, y}, {window_.high.x, y}, pen);
  outline_box({{0, 0}, image_size}, {on_white::kInk, 2, 0.6f});
}

void FrameCanvas::fill_box(const Box& box, glm::vec3 color, float opacity) {
  fill_polygon(picture_, corners_of(to_picture(box.low), to_picture(box.high)), color, opacity);
}

void FrameCanvas::outline_box(const Box& box, const Pen& pen) {
  stroke(picture_, corners_of(to_picture(box.low), to_picture(box.high)), true, pen);
}

void FrameCanvas::draw_ellipse(const Footprint& footprint, const Pen& pen, float fill_opacity) {
  std::vector<glm::vec2> points = ellipse_of(footprint, 360);
  for (glm::vec2& point : points) point = to_picture(point);
  if (fill_opacity > 0) fill_polygon(picture_, points, pen.color, fill_opacity);
  stroke(picture_, points, true, pen);
}

void FrameCanvas::draw_dot(glm::vec2 at, float radius, glm::vec3 color) {
  const glm::vec2 points[] = {to_picture(at), to_picture(at) + glm::vec2(0.01f, 0)};
  stroke(picture_, points, false, {color, 2 * radius});
}

void FrameCanvas::draw_line(glm::vec2 from, glm::vec2 to, const Pen& pen) {
  const glm::vec2 points[] = {to_picture(from), to_picture(to)};
  stroke(picture_, points, false, pen);
}

Box window_of(const GaussianReport& report, const TileGrid& grid) {
  glm::vec2 low = report.footprint.mean_px, high = low;
  if (report.visible) {
    low = glm::min(low, report.adr.low);
    high = glm::max(high, report.adr.high);
  }
  const auto side = static_cast<float>(grid.tile_px);
  for (const ModeTiles& mode : report.modes) {
    for (const int tile : mode.tiles) {
      const Box box = box_of_tile(grid, tile);
      low = glm::min(low, box.low);
      high = glm::max(high, box.high);
    }
  }
  // At most two tiles beyond the image are shown.
  const glm::vec2 last = side * glm::vec2(grid.columns, grid.rows);
  low = glm::clamp(low, glm::vec2(-2 * side), last);
  high = glm::clamp(high, glm::vec2(0), last + 2 * side);
  return {glm::floor(low / side) * side - side, glm::ceil(high / side) * side + side};
}

Image draw_construction(const ConstructionInput& input) {
  const GaussianReport& g = *input.inspection.gaussian;
  const Fonts fonts;
  const Box window = window_of(g, input.grid);
  Image page = plain_picture(kWidth, kMostHeight, on_white::kWhite);
  const int below_title = write(page, {fonts.title, kInk, 4}, {kFigureMargin, kFigureMargin},
                                fmt::format("Gaussian {}", grouped(g.gaussian)));
  const int top = write(
      page, {fonts.text, kFaint, 22}, {kFigureMargin, below_title},
      fmt::format("{} \u00b7 tiles of {} \u00d7 {} pixels, drawn to scale, {:.1f} times as large",
                  input.where, input.grid.tile_px, input.grid.tile_px,
                  FrameCanvas(window, kMain).scale()));
  const Image main = main_panel(input, window);
  paste(page, main, {kFigureMargin, top});

  const int facts_left = kWidth - kFigureMargin - kFacts,
            walk_left = facts_left - kFigureGap - kWalk.x;
  const ModeTiles& quad = g.modes[static_cast<std::size_t>(kQuad) - 1];
  const int walk_top =
      write(page, {fonts.head, kInk, 8}, {walk_left, top},
            fmt::format("QPass walks {} {}{}", quad.runs.size(), quad.walks_rows ? "row" : "column",
                        quad.runs.size() == 1 ? "" : "s"));
  const Image walk = walk_panel(input, window, fonts.small);
  paste(page, walk, {walk_left, walk_top});
  const int legend_bottom = draw_legend(page, fonts, {walk_left, walk_top + walk.height + 18}, g);
  const int pixel_top =
      draw_facts(page, fonts, {facts_left, top}, "The Gaussian", gaussian_facts(g)) + 14;
  const glm::ivec2 pixel = input.inspection.pixel.pixel;
  const int facts_bottom =
      draw_facts(page, fonts, {facts_left, pixel_top},
                 fmt::format("Pixel {}, {}", pixel.x, pixel.y), pixel_facts(input.inspection));

  const int modes_top =
      std::max({top + main.height, legend_bottom, facts_bottom}) + kFigureGap + 44;
  draw_text(
      page, fonts.text, {kFigureMargin, modes_top - 38},
      "The tiles that each mode lists. Strong: a pixel uses the pair. Medium: it reaches only "
      "pixels that have stopped. Pale: it reaches no pixel.",
      kFaint);
  const int bottom = draw_mode_panels(page, fonts, modes_top, input, window);
  return cropped(page, {0, 0, kWidth, bottom + kFigureMargin});
}

}  // namespace qs
