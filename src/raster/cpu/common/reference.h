// SPDX-License-Identifier: MIT
//
// Mode `reference`: 3DGS in double precision, the ground truth for the images of all modes. It uses
// no tiles: a Gaussian is tried at the pixels in its bounding box of alpha >= 1/255, grown by one
// pixel. A test shows that trying every pixel gives the same image.
#pragma once

#include "raster/cpu/common/frame_context.h"

namespace qs::cpu {

/// Fills color, depth, evaluated (Gaussians tried until the pixel stops), stats.visible and the
/// trace of `result`, as far as `outputs` requests them.
void render_reference(const FrameContext& frame, const Outputs& outputs, Frame& result);

}  // namespace qs::cpu
