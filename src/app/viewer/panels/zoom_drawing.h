// SPDX-License-Identifier: MIT
//
// Draws the chart of the zoom recorder. Its numbers come from state/zoom_chart.h.
#pragma once

#include <imgui.h>

#include "app/viewer/state/zoom_chart.h"

namespace qs {

/// The colour of a mode's curve.
ImVec4 zoom_color(CullMode mode, float opacity = 1);

/// Fills the width of the panel; shows the values at the cursor. Nothing without curves.
void draw_zoom_chart(const ZoomChart& chart);

}  // namespace qs
