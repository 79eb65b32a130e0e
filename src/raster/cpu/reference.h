// SPDX-License-Identifier: MIT
//
// Mode `reference`: the rules of 3DGS in double precision, the image that every mode is judged
// against. No tiles decide anything: a Gaussian acts on the pixels inside its own bounding box of
// alpha >= 1/255, grown by one pixel (a test proves that equal to trying every pixel).
#pragma once

#include "raster/cpu/frame_context.h"

namespace qs::cpu {

/// Fills result.color (and result.evaluated: Gaussians considered up to the stop) and the visible
/// count.
void render_reference(const FrameContext& frame, const Outputs& outputs, Frame& result);

}  // namespace qs::cpu
