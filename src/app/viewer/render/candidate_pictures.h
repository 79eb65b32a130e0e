// SPDX-License-Identifier: MIT
//
// Draws the candidates for the first view of a scene as small pictures.
#pragma once

#include "app/viewer/render/render_context.h"

namespace qs {

/// Pictures of these views side by side, each `width` > 0 pixels wide and 9/16 as high. Throws
/// Error and Cancelled.
Image draw_candidates(RenderContext& context, const std::vector<Framing>& views,
                      const RenderSettings& settings, int width);

namespace action {

/// Starts to draw the pictures that Viewer::view_choice waits for, once the window shows the scene.
void follow_view_choice(Viewer& viewer, Host& host);

}  // namespace action
}  // namespace qs
