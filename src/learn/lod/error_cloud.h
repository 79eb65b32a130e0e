// SPDX-License-Identifier: MIT
//
// The estimated errors or the levels of a cut as a scene: its picture is a map of them.
#pragma once

#include <cstdint>
#include <span>

#include "io/scene/rad/rad.h"
#include "raster/pages/cut.h"
#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// The Gaussians of a cut in grey. On black, the camera's picture of them is the estimated squared
/// error of each pixel, colour^2, sum over RGB. `drawn`: cut_cloud() of the cut.
GaussianCloud error_cloud(const RadLevels& levels, std::span<const std::uint32_t> cut,
                          GaussianCloud drawn, const Camera& camera);

/// The same for a cut in a view: paints `drawn`, which is its cut_cloud(), with errors as
/// error_cloud() does, or with levels: 0 for a leaf, k / 255 for a node whose leaves have a sum of
/// opacities below 2^k.
void paint_levels(const LodPages& tree, const LodCut& cut, const LodView& view, double dilation,
                  bool errors, GaussianCloud& drawn);

}  // namespace qs
