// SPDX-License-Identifier: MIT
//
// Scales of round numbers, and the legend of a map: a title, a bar of colours with ticks, and
// facts. Pictures that are saved have it below them, pictures of a fixed size over their top.
// Figures and the window draw the same bar in their own sizes, by bar_colors() and place_ticks().
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "app/picture/canvas.h"
#include "raster/scene/image.h"

namespace qs {

/// The first of 1, 2 and 5 times powers of ten for which fits(step), from the power at or below
/// `from` on, which is > 0.
template <class Fits>
double round_step(double from, const Fits& fits) {
  for (double power = std::pow(10.0, std::floor(std::log10(from)));; power *= 10)
    for (const double step : {power, 2 * power, 5 * power})
      if (fits(step)) return step;
}

struct Scale {
  std::uint32_t step = 1;                    ///< 1, 2 or 5 times a power of ten
  std::uint32_t maximum = 1;                 ///< the end of the scale, at least 1
  std::vector<std::uint32_t> ticks() const;  ///< 0, step, ..., maximum
  bool operator==(const Scale&) const = default;
};

/// A scale up to at least `maximum` in four to eight steps (fewer below 4).
Scale round_scale(std::uint32_t maximum);

/// The scale up to exactly `maximum`, with the steps of round_scale(). 0 is drawn as 1.
Scale exact_scale(std::uint32_t maximum);

/// round_scale() of the 99.5th percentile, so that a few extreme values do not darken all others.
Scale scale_for(std::span<const std::uint32_t> values);

/// scale_for() the absolute values; the scale is used from -maximum to maximum.
Scale scale_for_signed(std::span<const std::int32_t> values);

/// A tick of a colour bar.
struct BarTick {
  float at = 0;  ///< 0: the left end, 1: the right end
  std::string text;
};

struct Legend {
  std::string title, facts = {};
  std::vector<BarTick> ticks;             ///< ticks from left to right
  std::function<glm::vec3(float)> color;  ///< the colour at a place from 0 to 1
  std::optional<glm::vec3> zero = {};     ///< the bar begins with this colour, of the value 0
};

/// The colours of a bar that is `width` x `height` pixels large: one for each column of pixels. The
/// value 0 has half as many columns as the bar is high.
std::vector<glm::vec3> bar_colors(const Legend& legend, int width, int height);

/// A tick of a bar of some width: the places of its line and of its text, in pixels from the left.
struct PlacedTick {
  int line = 0, text = 0;
  Align align = Align::left;  ///< alignment of the text at its place
  bool has_text = true;       ///< false: the text would touch its neighbour
};

/// Places the ticks from the last text, which may have a unit, to the left. The texts at both ends
/// stay inside of the bar. `gap`: least distance between texts; `text_width`: of a text in pixels.
std::vector<PlacedTick> place_ticks(const std::vector<BarTick>& ticks, int width, int gap,
                                    const std::function<int(const std::string&)>& text_width);

/// The picture with the legend below it. The width stays.
Image with_legend(const Image& picture, const Legend& legend);

/// Draws title and bar over the top of `picture`. A picture that is less than four times as high as
/// they are stays as it is.
void draw_legend_over(Image& picture, const Legend& legend);

}  // namespace qs
