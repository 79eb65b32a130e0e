// SPDX-License-Identifier: MIT
//
// The bar of colours below or beside a map, with its ticks. Inside of an ImGui window.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "app/picture/colormap.h"

namespace qs {

struct Tick {
  float at;  ///< share of the bar, 0..1
  std::string text;
};

/// As wide as there is room; `color(t)` for t from 0 to 1. `ticks` from left to right, the first
/// and the last at its ends.
void draw_color_bar(const std::function<glm::vec3(float)>& color, const std::vector<Tick>& ticks);

}  // namespace qs
