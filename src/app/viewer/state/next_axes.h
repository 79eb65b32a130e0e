// SPDX-License-Identifier: MIT
//
// Turning a scene upright: its file is read as if its axes were others.
#pragma once

#include "app/viewer/state/action.h"

namespace qs::action {

/// Reads the scene's file with the next frame of axes, and remembers the frame for this file. After
/// the last frame come the axes that the file declares.
void next_axes(Viewer& viewer, Host& host);

/// Reads the scene's file turned by 180 degrees about the view's right axis, and remembers that for
/// this file. A second call turns it back.
void turn_over(Viewer& viewer, Host& host);

}  // namespace qs::action
