// SPDX-License-Identifier: MIT
//
// The axes of a plot in a panel: lines at the ticks, their texts, and the title of the lower axis.
#pragma once

#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <imgui.h>

#include "app/picture/legend.h"

namespace qs {

/// The area of the curves in the window, screen units.
struct PlotArea {
  ImVec2 low, high;

  /// `place`: fractions of the width from the left and of the height from the bottom.
  ImVec2 at(glm::dvec2 place) const {
    return {low.x + static_cast<float>(place.x) * (high.x - low.x),
            high.y - static_cast<float>(place.y) * (high.y - low.y)};
  }

  /// The fraction of the width from the left at which the mouse is.
  double mouse_x() const {
    return static_cast<double>((ImGui::GetIO().MousePos.x - low.x) / (high.x - low.x));
  }
};

struct PlotAxes {
  std::vector<BarTick> across, up;  ///< from the left, and from the bottom
  std::string title;                ///< of the lower axis
};

/// Draws the axes of a plot that fills the width of the panel, `height` screen units high. Texts
/// that would touch the previous one are left out. The item is hovered while the mouse is on it.
PlotArea draw_plot_axes(const char* name, const PlotAxes& axes, float height);

}  // namespace qs
