// SPDX-License-Identifier: MIT
//
// A bar of colours with ticks below it, inside an ImGui window.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "app/picture/colormap.h"
#include "app/viewer/state/panel_text.h"

namespace qs {

/// Fills the width of the window. `color(t)` for t from 0 to 1; `ticks` from left to right, the
/// first and the last at the ends.
void draw_color_bar(const std::function<glm::vec3(float)>& color,
                    const std::vector<BarTick>& ticks);

}  // namespace qs
