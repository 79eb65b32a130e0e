// SPDX-License-Identifier: MIT
//
// The layout of the window: the picture, the bars of panels, and the lines above and below them.
// Bars of panels are beside the picture, never on it.
#pragma once

#include "app/viewer/state/viewer.h"

namespace qs {

/// Screen units of the window: x to the right, y down, from its top left corner.
struct Rect {
  glm::vec2 low{0.0f}, high{0.0f};
  glm::vec2 size() const { return high - low; }
  glm::vec2 center() const { return 0.5f * (low + high); }
  bool empty() const { return high.x <= low.x || high.y <= low.y; }
  bool operator==(const Rect&) const = default;
};

/// The window's size, and the heights of a letter and of a line of the menu, screen units.
struct WindowMetrics {
  glm::vec2 size{1280, 720};
  float letter = 15, line = 23;
};

/// Empty rectangles are not drawn.
struct Layout {
  Rect menu, left, right, status, picture;

  /// The picture as it would be without bars.
  Rect between_lines() const {
    return {{menu.empty() ? picture.low.x : menu.low.x, picture.low.y},
            {menu.empty() ? picture.high.x : menu.high.x, picture.high.y}};
  }
};

/// The switches of the panels in the bars, from top to bottom.
inline constexpr bool Panels::*kLeftPanels[] = {&Panels::hud, &Panels::split, &Panels::recorder};
inline constexpr bool Panels::*kRightPanels[] = {&Panels::training,  &Panels::crop,
                                                 &Panels::inspector, &Panels::cameras,
                                                 &Panels::info,      &Panels::messages};

Layout layout_of(const Viewer& viewer, const WindowMetrics& window);

}  // namespace qs
