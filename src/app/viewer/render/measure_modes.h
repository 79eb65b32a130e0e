// SPDX-License-Identifier: MIT
//
// Measures all modes of a view off screen, for the table of modes.
#pragma once

#include "app/viewer/render/render_context.h"

namespace qs {

struct NumbersRequest {
  Camera camera;
  RenderSettings settings;
  int version = 0;    ///< Viewer::view_version
  bool more = false;  ///< adds frames to the numbers of this view
};

/// Reports mode_sampled() for the first frame of each mode, then numbers_measured(), or
/// numbers_refined() for `more`. A measurement that fails is reported without rows, so that it is
/// not repeated. Throws Error and Cancelled.
void measure_modes(RenderContext& context, const NumbersRequest& request);

/// Draws a frame that nobody sees and reports its time. `about`: its mode, its size and its view.
void sample_mode(RenderContext& context, const Camera& camera, const RenderSettings& settings,
                 ModeSample about);

}  // namespace qs
