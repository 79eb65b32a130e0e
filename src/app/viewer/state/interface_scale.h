// SPDX-License-Identifier: MIT
//
// The size of letters and lines, and of the first window. 100 % are 15 screen units for a letter.
#pragma once

#include "app/viewer/state/action.h"

namespace qs {

/// The scales that the user steps through.
inline constexpr float kInterfaceScales[] = {0.75f, 1.0f, 1.25f, 1.5f, 1.75f, 2.0f, 2.5f, 3.0f};

/// The user's choice, else Turn::screen_scale.
float interface_scale(const Viewer& viewer);

/// One of kInterfaceScales for a screen: the nearest to the scale that the system declares, in
/// letters per screen unit; if it declares 1 or less, a scale by the screen's size, up to 2.
float guessed_scale(float declared, glm::ivec2 screen);

/// 80 % of a screen, at least 640 x 400 if the screen has as much. All in screen units.
glm::ivec2 first_window_size(glm::ivec2 screen);

namespace action {

/// Steps to a larger (+1) or smaller (-1) interface.
void step_interface_scale(Viewer& viewer, int step);
void set_interface_scale(Viewer& viewer, float scale);

}  // namespace action
}  // namespace qs
