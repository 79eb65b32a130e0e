// SPDX-License-Identifier: MIT
//
// The layout of the window: the picture, the bars of panels, and the lines above and below them.
// Bars of panels are beside the picture, never on it. And the size of letters and lines: 100 % are
// 15 screen units for a letter.
#pragma once

#include "app/viewer/state/action.h"

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

/// Empty rectangles are not drawn. In a window too narrow for two bars `left` has all panels.
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
inline constexpr bool Panels::*kRightPanels[] = {
    &Panels::training, &Panels::crop, &Panels::measures, &Panels::inspector,
    &Panels::cameras,  &Panels::info, &Panels::messages};

Layout layout_of(const Viewer& viewer, const WindowMetrics& window);

/// The scales that the user steps through.
inline constexpr float kInterfaceScales[] = {0.75f, 1.0f, 1.25f, 1.5f, 1.75f, 2.0f, 2.5f, 3.0f};

/// The user's choice, else Turn::screen_scale.
float interface_scale(const Viewer& viewer);

/// One of kInterfaceScales for a screen: the nearest to the scale that the system declares, in
/// letters per screen unit; if it declares 1 or less, a scale by the screen's size, up to 2.
float guessed_scale(float declared, glm::ivec2 screen);

/// The smallest size to which the user can make the window, screen units.
inline constexpr glm::ivec2 kLeastWindow{320, 240};

/// 80 % of a screen, at least 640 x 400 if the screen has as much. All in screen units.
glm::ivec2 first_window_size(glm::ivec2 screen);

namespace action {

/// Steps to a larger (+1) or smaller (-1) interface.
void step_interface_scale(Viewer& viewer, int step);
void set_interface_scale(Viewer& viewer, float scale);

}  // namespace action
}  // namespace qs
