// SPDX-License-Identifier: MIT
#include "app/picture/legend.h"

#include <algorithm>

#include "app/picture/canvas.h"
#include "app/picture/palette.h"
#include "base/rank.h"

namespace qs {
namespace {

using on_dark::kFaint;
using on_dark::kText;

// Sizes of the legend in pixels, derived from the picture's width.
struct LegendLayout {
  int padding, text, title, bar, tick;
  bool two_lines;  // the facts are below the title, because both do not fit in one line
  int height() const {
    return padding + (two_lines ? title + text : title) + padding / 2 + bar + 2 * tick + text +
           padding;
  }
};

LegendLayout layout_in(int width, const Legend& legend) {
  const int text = std::clamp(width / 60, 14, 40);
  LegendLayout layout{text * 3 / 4, text, text * 6 / 5, text * 9 / 8, std::max(text / 4, 3), false};
  if (legend.facts.empty()) return layout;
  const int used = Font(layout.title).width(legend.title) + Font(layout.text).width(legend.facts);
  layout.two_lines = used + 4 * layout.padding > width;
  return layout;
}

// `top`: of the ticks.
void draw_ticks(Image& image, int left, int right, int top, const LegendLayout& layout,
                const std::vector<BarTick>& ticks) {
  const Font font(layout.text);
  const auto placed = place_ticks(ticks, right - left, layout.padding / 2,
                                  [&](const std::string& text) { return font.width(text); });
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    fill_rect(image, {left + placed[i].line, top, 1, layout.tick}, kFaint);
    if (placed[i].has_text)
      draw_text(image, font, {left + placed[i].text, top + 2 * layout.tick}, ticks[i].text, kText,
                placed[i].align);
  }
}

void draw_legend(Image& image, int top, const LegendLayout& layout, const Legend& legend) {
  const Font title_font(layout.title), text_font(layout.text);
  const int left = layout.padding, right = image.width - layout.padding;
  int y = top + layout.padding;
  draw_text(image, title_font, {left, y}, legend.title, kText);
  if (layout.two_lines) {
    draw_text(image, text_font, {left, y + layout.title}, legend.facts, kFaint);
  } else {
    const int baseline_shift = (layout.title - layout.text) * 4 / 5;
    draw_text(image, text_font, {right, y + baseline_shift}, legend.facts, kFaint, Align::right);
  }
  y += (layout.two_lines ? layout.title + layout.text : layout.title) + layout.padding / 2;
  int x = left;
  for (const glm::vec3 color : bar_colors(legend, right - left, layout.bar))
    fill_rect(image, {x++, y, 1, layout.bar}, color);
  draw_ticks(image, left, right, y + layout.bar, layout, legend.ticks);
}

}  // namespace

std::vector<std::uint32_t> Scale::ticks() const {
  std::vector<std::uint32_t> result;
  // A step that ends just below the maximum would collide with it.
  for (std::uint64_t tick = 0; tick == 0 || 2 * tick + step <= 2 * std::uint64_t{maximum};
       tick += step)
    result.push_back(static_cast<std::uint32_t>(tick));
  result.push_back(maximum);
  return result;
}

Scale round_scale(std::uint32_t maximum) {
  constexpr std::uint64_t kMostSteps = 8;
  constexpr std::uint64_t kLargest = 4'000'000'000;
  const std::uint64_t reach = std::clamp<std::uint64_t>(maximum, 1, kLargest);
  const auto steps_of = [reach](std::uint64_t step) { return (reach + step - 1) / step; };
  const auto step = static_cast<std::uint64_t>(round_step(
      1, [&](double size) { return steps_of(static_cast<std::uint64_t>(size)) <= kMostSteps; }));
  return {static_cast<std::uint32_t>(step), static_cast<std::uint32_t>(steps_of(step) * step)};
}

Scale exact_scale(std::uint32_t maximum) {
  const std::uint32_t end = std::max(maximum, 1u);
  return {round_scale(end).step, end};
}

Scale scale_for(std::span<const std::uint32_t> values) {
  if (values.empty()) return {};
  std::vector<std::uint32_t> sorted(values.begin(), values.end());
  return round_scale(at_rank(sorted, (sorted.size() - 1) * 995 / 1000));
}

Scale scale_for_signed(std::span<const std::int32_t> values) {
  std::vector<std::uint32_t> sizes;
  sizes.reserve(values.size());
  for (const std::int32_t value : values)
    sizes.push_back(static_cast<std::uint32_t>(value < 0 ? -std::int64_t{value} : value));
  return scale_for(sizes);
}

std::vector<glm::vec3> bar_colors(const Legend& legend, int width, int height) {
  std::vector<glm::vec3> colors;
  for (int x = 0; x < width; ++x) {
    const float t = (static_cast<float>(x) + 0.5f) / static_cast<float>(width);
    const bool zero = legend.zero && 2 * x < height;
    colors.push_back(zero ? *legend.zero : legend.color(t));
  }
  return colors;
}

std::vector<PlacedTick> place_ticks(const std::vector<BarTick>& ticks, int width, int gap,
                                    const std::function<int(const std::string&)>& text_width) {
  std::vector<PlacedTick> placed(ticks.size());
  int free_until = width;
  for (std::size_t i = ticks.size(); i-- > 0;) {
    PlacedTick& tick = placed[i];
    tick.line = static_cast<int>(ticks[i].at * static_cast<float>(width - 1));
    const bool last = i + 1 == ticks.size();
    tick.text = last ? width : tick.line;
    tick.align = last ? Align::right : i == 0 ? Align::left : Align::center;
    const int text = text_width(ticks[i].text);
    const int start = last ? width - text : i == 0 ? tick.line : tick.line - text / 2;
    tick.has_text = last || start + text <= free_until;
    if (tick.has_text) free_until = start - gap;
  }
  return placed;
}

Image with_legend(const Image& picture, const Legend& legend) {
  const LegendLayout layout = layout_in(picture.width, legend);
  Image result(picture.width, picture.height + layout.height(), 3);
  paste(result, picture, {0, 0});
  fill_rect(result, {0, picture.height, result.width, layout.height()}, on_dark::kPanel);
  draw_legend(result, picture.height, layout, legend);
  return result;
}

void draw_legend_over(Image& picture, const Legend& legend) {
  constexpr float kPlateOpacity = 0.7f;
  Legend shown = legend;
  shown.facts.clear();
  const LegendLayout layout = layout_in(picture.width, shown);
  if (4 * layout.height() > picture.height) return;
  fill_polygon(picture, corners_of({0, 0}, {picture.width, layout.height()}), on_dark::kPanel,
               kPlateOpacity);
  draw_legend(picture, 0, layout, shown);
}

}  // namespace qs
