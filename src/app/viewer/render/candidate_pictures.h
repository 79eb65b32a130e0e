// SPDX-License-Identifier: MIT
//
// Draws the candidates for the first view of a scene as small pictures.
#pragma once

#include "app/viewer/render/render_context.h"

namespace qs::action {

/// Starts to draw the pictures that Viewer::view_choice waits for, once the window shows the scene.
void follow_view_choice(Viewer& viewer, Host& host);

}  // namespace qs::action
