// SPDX-License-Identifier: MIT
//
// The bar of a legend with its ticks below it, inside an ImGui window.
#pragma once

#include "app/picture/legend.h"

namespace qs {

/// Fills the width of the window.
void draw_color_bar(const Legend& legend);

}  // namespace qs
