// SPDX-License-Identifier: MIT
//
// Draws frames into host memory: all frames of a backend without GL textures, and frames that need
// two renderings (a split window, the map of missed contributions) or show other quantities than
// colour.
#pragma once

#include "app/viewer/render/render_context.h"

namespace qs {

/// The facts of a frame, without its maps.
ShownFrame shown_of(const FrameRequest& request, const Frame& frame);

/// `outputs`, and the counts of all modes if the request asks for them.
Outputs with_counts(Outputs outputs, const FrameRequest& request);

/// 8-bit RGBA, rows from the top. `pool`: null for the caller's thread alone.
std::vector<std::uint8_t> to_rgba(const Image& image, ThreadPool* pool = nullptr);
/// The colours of such pixels.
Image image_of(const std::vector<std::uint8_t>& rgba, int width, int height);

/// A frame in host memory, without its maps.
RenderedFrame rendered_of(const RenderContext& context, const FrameRequest& request,
                          const Frame& frame);

/// True if one rendering of colours is enough.
bool takes_one_frame(const FrameRequest& request);

/// `camera`: the request's, at the size to draw. Throws Error and Cancelled.
RenderedFrame draw_on_host(RenderContext& context, const FrameRequest& request,
                           const Camera& camera);

// ---- heat maps ---------------------------------------------------------------------------------
// The scale of heat maps. All modes of a view share it, so that colours can be compared: it fits
// the map of the baseline. While the camera moves it is held, so that colours do not jump.

/// The scale for the heat maps of a request. `camera`: of the frame to draw. Renders the baseline
/// if this view has no scale yet. A request without a heat map gets an empty scale. Throws Error
/// and Cancelled.
HeldScale heat_scale(RenderContext& context, const FrameRequest& request, const Camera& camera);

/// Sets the first heat map of a frame.
void show_map(ShownFrame& shown, Heatmap map, const HeldScale& scale);

}  // namespace qs
