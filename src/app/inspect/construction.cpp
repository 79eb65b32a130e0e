// SPDX-License-Identifier: MIT
#include "app/inspect/construction.h"

#include <algorithm>
#include <cassert>

#include <fmt/format.h>

#include "app/inspect/inspection_text.h"
#include "app/inspect/magnifier.h"
#include "app/picture/canvas.h"
#include "app/picture/palette.h"
#include "app/session/text.h"

namespace qs {
namespace {

using paper::kFaint;
using paper::kInk;
using paper::mode_color;

constexpr int kWidth = 1800, kMargin = 40, kGap = 28;
constexpr glm::ivec2 kMain{860, 640}, kWalk{440, 420};
constexpr int kFacts = kWidth - 2 * kMargin - kMain.x - kWalk.x - 2 * kGap;
constexpr int kMultipleHeight = 250;
constexpr glm::vec3 kEllipse{0.80f, 0.15f, 0.15f}, kPick{0.0f, 0.62f, 0.45f};

constexpr CullMode k3dgs = find_culler("3dgs"), kAdr = find_culler("adr"),
                   kDual = find_culler("dualbox"), kQuad = find_culler("quadbox");

struct Fonts {
  Font title{38}, head{26}, text{22}, small{19};
};

/// One entry of the legend: a sample of the line, and its words. Returns the next line's top.
int legend_line(Image& page, const Font& font, glm::ivec2 at, const Pen& pen, float fill,
                const std::string& words) {
  const float top = static_cast<float>(at.y) + 5, left = static_cast<float>(at.x);
  const glm::vec2 box[] = {{left, top}, {left + 34, top}, {left + 34, top + 14}, {left, top + 14}};
  if (fill > 0) fill_polygon(page, box, pen.color, fill);
  stroke(page, box, true, pen);
  draw_text(page, font, {at.x + 46, at.y}, words, kInk);
  return at.y + font.line_height() + 5;
}

Pen square_pen() { return {kInk, 2.5f, 1, 9}; }
Pen adr_pen() { return {mode_color(kAdr), 3}; }
Pen dual_pen() { return {mode_color(kDual), 3}; }
Pen quad_pen() { return {mode_color(kQuad), 2.5f}; }
Pen ellipse_pen() { return {kEllipse, 2.5f}; }

Image main_panel(const ConstructionInput& input, const Box& window) {
  const GaussianReport& g = *input.inspection.gaussian;
  Magnifier panel(window, kMain);
  panel.draw_frame(input.color, 0.3f);
  panel.draw_grid(input.grid, {input.color.width, input.color.height});
  for (const Box& box : g.quad_boxes) panel.fill_box(box, mode_color(kQuad), 0.16f);
  for (const Box& box : g.dual_boxes) panel.fill_box(box, mode_color(kDual), 0.3f);
  panel.outline_box(g.square, square_pen());
  if (g.visible) {
    panel.outline_box(g.adr, adr_pen());
    panel.draw_ellipse(g.footprint, ellipse_pen(), 0.22f);
  }
  for (const Box& box : g.quad_boxes) panel.outline_box(box, quad_pen());
  for (const Box& box : g.dual_boxes) panel.outline_box(box, dual_pen());
  const glm::vec2 pixel(input.inspection.pixel.pixel);
  panel.draw_dot(g.footprint.mean_px, 5, kEllipse);
  const float half = std::max(0.5f, 5 / panel.scale());
  panel.outline_box({pixel - half, pixel + half}, {kPick, 3});
  return panel.picture();
}

/// The lines that QPass walks, numbered in its order, with the interval that it finds in each.
Image walk_panel(const ConstructionInput& input, const Box& window, const Font& font) {
  const GaussianReport& g = *input.inspection.gaussian;
  const ModeTiles& quad = g.modes[static_cast<std::size_t>(kQuad) - 1];
  Magnifier panel(window, kWalk);
  panel.draw_grid(input.grid, {input.color.width, input.color.height});
  for (const Box& box : g.quad_boxes) panel.outline_box(box, {mode_color(kQuad), 1.5f, 0.7f});
  if (g.visible) panel.draw_ellipse(g.footprint, {kEllipse, 1.5f, 0.8f}, 0);
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
    const Pen pen{mode_color(kQuad), 3};
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

Image mode_panel(const ConstructionInput& input, const Box& window, std::size_t index, int width) {
  const GaussianReport& g = *input.inspection.gaussian;
  const ModeTiles& mode = g.modes[index];
  const glm::vec3 color = mode_color(mode.mode);
  Magnifier panel(window, {width, kMultipleHeight});
  for (std::size_t i = 0; i < mode.tiles.size(); ++i) {
    constexpr float kOpacity[] = {0.8f, 0.38f, 0.12f};  // index = PairUse
    panel.fill_tile(input.grid, mode.tiles[i], color,
                    kOpacity[static_cast<int>(input.inspection.uses[index][i])]);
  }
  panel.draw_grid(input.grid, {input.color.width, input.color.height});
  for (const int tile : mode.tiles) panel.outline_tile(input.grid, tile, {color, 1.2f});
  if (g.visible) {
    panel.draw_ellipse(g.footprint, {paper::kWhite, 4.5f, 0.85f}, 0);  // it shows on dark tiles too
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
      {"background shows", fmt::format("{:.2f} %", 100 * pixel.transmittance)}};
  for (const Contribution& c : pixel.contributions) {
    if (c.gaussian != inspection.gaussian->gaussian) continue;
    facts.push_back({"this one's alpha", fmt::format("{:.4f}", c.alpha)});
    facts.push_back({"transmittance before", fmt::format("{:.4f}", c.transmittance)});
    facts.push_back({"weight", fmt::format("{:.4f}", c.weight)});
  }
  return facts;
}

/// Returns where the next line would be.
int draw_facts(Image& page, const Fonts& fonts, glm::ivec2 at, const std::string& title,
               const std::vector<InspectedFact>& facts) {
  draw_text(page, fonts.head, at, title, kInk);
  int y = at.y + fonts.head.line_height() + 8;
  for (const InspectedFact& fact : facts) {
    draw_text(page, fonts.small, {at.x, y}, fact.label, kFaint);
    draw_text(page, fonts.small, {at.x + kFacts, y}, fact.value, kInk, Align::right);
    y += fonts.small.line_height() + 6;
  }
  return y;
}

void draw_multiples(Image& page, const Fonts& fonts, int top, const ConstructionInput& input,
                    const Box& window) {
  const GaussianReport& g = *input.inspection.gaussian;
  const int count = static_cast<int>(g.modes.size());
  const int gap = 18, width = (kWidth - 2 * kMargin - (count - 1) * gap) / count;
  for (int i = 0; i < count; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const int left = kMargin + i * (width + gap);
    const Image panel = mode_panel(input, window, index, width);
    paste(page, panel, {left + (width - panel.width) / 2, top});
    const PairUses uses = uses_of(input.inspection, index);
    int y = top + panel.height + 10;
    draw_text(page, fonts.head, {left + width / 2, y},
              fmt::format("{}: {} tiles", mode_name(g.modes[index].mode), uses.pairs()), kInk,
              Align::center);
    y += fonts.head.line_height() + 4;
    draw_text(page, fonts.small, {left + width / 2, y},
              fmt::format("{} used, {} hidden, {} empty", uses.used, uses.hidden, uses.empty),
              kFaint, Align::center);
  }
}

int draw_legend(Image& page, const Fonts& fonts, glm::ivec2 at, const GaussianReport& g) {
  int y = at.y;
  const auto& square = g.modes[static_cast<std::size_t>(k3dgs) - 1];
  y = legend_line(page, fonts.small, {at.x, y}, ellipse_pen(), 0.22f, "where alpha reaches 1/255");
  y = legend_line(page, fonts.small, {at.x, y}, square_pen(), 0,
                  fmt::format("{}: square of three sigma", mode_name(square.mode)));
  y = legend_line(page, fonts.small, {at.x, y}, adr_pen(), 0, "adr: the ellipse's box");
  y = legend_line(page, fonts.small, {at.x, y}, dual_pen(), 0.3f,
                  "dualbox: its two major quadrants");
  y = legend_line(page, fonts.small, {at.x, y}, quad_pen(), 0.16f,
                  fmt::format("quadbox: those and two of {:.2f} times the size", g.f));
  return legend_line(page, fonts.small, {at.x, y}, {kPick, 3}, 0, "the pixel");
}

}  // namespace

Image draw_construction(const ConstructionInput& input) {
  assert(input.inspection.gaussian.has_value());
  const GaussianReport& g = *input.inspection.gaussian;
  const Fonts fonts;
  const Box window = window_of(g, input.grid);
  const Image main = main_panel(input, window), walk = walk_panel(input, window, fonts.small);

  const int top = kMargin + fonts.title.line_height() + fonts.text.line_height() + 26;
  const int legend_height = 6 * (fonts.small.line_height() + 5);
  const int walk_height = fonts.head.line_height() + 8 + walk.height + 18 + legend_height;
  const std::vector<InspectedFact> shape = gaussian_facts(g), seen = pixel_facts(input.inspection);
  const int facts_height =
      static_cast<int>(shape.size() + seen.size()) * (fonts.small.line_height() + 6) +
      2 * (fonts.head.line_height() + 8) + 14;
  const int multiples_top = top + std::max({main.height, walk_height, facts_height}) + kGap + 44;
  const Image one = mode_panel(input, window, 0, (kWidth - 2 * kMargin - 5 * 18) / 6);
  const int height = multiples_top + one.height + 10 + fonts.head.line_height() + 4 +
                     fonts.small.line_height() + kMargin;

  Image page(kWidth, height, 3);
  fill_rect(page, {0, 0, page.width, page.height}, paper::kWhite);
  draw_text(page, fonts.title, {kMargin, kMargin}, fmt::format("Gaussian {}", grouped(g.gaussian)),
            kInk);
  draw_text(
      page, fonts.text, {kMargin, kMargin + fonts.title.line_height() + 4},
      fmt::format("{} \u00b7 tiles of {} \u00d7 {} pixels, drawn to scale, {:.1f} times as large",
                  input.where, input.grid.tile_px, input.grid.tile_px,
                  Magnifier(window, kMain).scale()),
      kFaint);
  paste(page, main, {kMargin, top});

  const int walk_left = kWidth - kMargin - kFacts - kGap - kWalk.x;
  const ModeTiles& quad = g.modes[static_cast<std::size_t>(kQuad) - 1];
  draw_text(page, fonts.head, {walk_left, top},
            fmt::format("QPass walks {} {}{}", quad.runs.size(), quad.walks_rows ? "row" : "column",
                        quad.runs.size() == 1 ? "" : "s"),
            kInk);
  paste(page, walk, {walk_left, top + fonts.head.line_height() + 8});
  draw_legend(page, fonts, {walk_left, top + fonts.head.line_height() + 8 + walk.height + 18}, g);
  const int facts_left = walk_left + kWalk.x + kGap;
  const int next = draw_facts(page, fonts, {facts_left, top}, "The Gaussian", shape) + 14;
  const glm::ivec2 pixel = input.inspection.pixel.pixel;
  draw_facts(page, fonts, {facts_left, next}, fmt::format("Pixel {}, {}", pixel.x, pixel.y), seen);

  draw_text(page, fonts.text, {kMargin, multiples_top - 38},
            "The tiles that each mode lists. Strong: a pixel uses the pair. Medium: hidden behind "
            "pixels that have stopped. Pale: no pixel is reached.",
            kFaint);
  draw_multiples(page, fonts, multiples_top, input, window);
  return page;
}

}  // namespace qs
