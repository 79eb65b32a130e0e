// SPDX-License-Identifier: MIT
//
// The legend of a map: a title, a bar of colours with ticks, and facts. Pictures that are saved
// have it below them, pictures of a fixed size over their top. The window draws its own.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "raster/scene/image.h"

namespace qs {

/// A tick of a colour bar.
struct BarTick {
  float at = 0;  ///< 0: the left end, 1: the right end
  std::string text;
};

struct Legend {
  std::string title, facts;
  std::vector<BarTick> ticks;             ///< from left to right; the last text has the unit
  std::function<glm::vec3(float)> color;  ///< of a place from 0 to 1
  std::optional<glm::vec3> zero = {};     ///< the bar begins with this colour, of the value 0
};

/// The picture with the legend below it. The width stays.
Image with_legend(const Image& picture, const Legend& legend);

/// Draws title and bar over the top of `picture`. A picture that is less than four times as high as
/// they are stays as it is.
void draw_legend_over(Image& picture, const Legend& legend);

}  // namespace qs
