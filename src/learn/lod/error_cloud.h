// SPDX-License-Identifier: MIT
//
// The estimated errors or the levels of a cut as a scene: its picture is a map of them.
#pragma once

#include "raster/pages/cut.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Paints `drawn`, the cut_cloud() of a cut in a view, in grey. With `errors`, its picture on black
/// is the estimated squared error of each pixel, colour^2, sum over RGB; else a leaf has 0 and a
/// node whose leaves have a sum of opacities below 2^k has k / 255.
void paint_levels(const LodPages& tree, const LodCut& cut, const LodView& view, double dilation,
                  bool errors, GaussianCloud& drawn);

}  // namespace qs
