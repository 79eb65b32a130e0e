// SPDX-License-Identifier: MIT
//
// Drawings of the inspector with ImGui's lines, sharp at every scale of the window.
#pragma once

#include "app/viewer/state/viewer.h"

namespace qs {

/// The transmittance of the pixel from the nearest of its Gaussians to the farthest.
void draw_transmittance(const PixelReport& pixel);

/// The bounds of the picked Gaussian: its ellipse and boxes over the tiles that `mode` lists, a
/// legend, and the counts of all modes. The inspection must have a picked Gaussian.
void draw_construction_view(const InspectedView& view, CullMode mode);

}  // namespace qs
