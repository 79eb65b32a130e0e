// SPDX-License-Identifier: MIT
//
// Frames as pixels of the host: all of a backend without GL textures, and those that take two
// frames to draw, of a split window or of a map of what a mode misses.
#pragma once

#include "app/viewer/render/render_context.h"

namespace qs {

/// What the window is told of every frame, whatever way it takes.
ShownFrame shown_of(const FrameOrder& order, const RenderStats& stats);

/// Whether one frame is all that was ordered.
bool takes_one_frame(const FrameOrder& order);

/// `camera`: the order's, at the size to draw. Throws Error and Cancelled.
FrameReply draw_on_host(RenderContext& context, const FrameOrder& order, const Camera& camera);

}  // namespace qs
