// SPDX-License-Identifier: MIT
//
// The scale of heat maps. All modes of a view share it, so that colours can be compared: it fits
// the map of the baseline. While the camera moves it is held, so that colours do not jump.
#pragma once

#include "app/viewer/render/render_context.h"

namespace qs {

/// The scale for the heat maps of a request. `camera`: of the frame to draw. Renders the baseline
/// if this view has no scale yet. A request without a heat map gets an empty scale. Throws Error
/// and Cancelled.
HeldScale heat_scale(RenderContext& context, const FrameRequest& request, const Camera& camera);

/// Sets the first heat map of a frame.
void show_map(ShownFrame& shown, Heatmap map, const HeldScale& scale);

}  // namespace qs
