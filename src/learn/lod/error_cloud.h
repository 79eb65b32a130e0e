// SPDX-License-Identifier: MIT
//
// The estimated errors of a cut as a scene: its picture is a map of them.
#pragma once

#include <cstdint>
#include <span>

#include "io/scene/rad/rad.h"
#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// The Gaussians of a cut in grey. On black, the camera's picture of them is the estimated squared
/// error of each pixel, colour^2, sum over RGB. `drawn`: cut_cloud() of the cut.
GaussianCloud error_cloud(const RadLevels& levels, std::span<const std::uint32_t> cut,
                          GaussianCloud drawn, const Camera& camera);

}  // namespace qs
