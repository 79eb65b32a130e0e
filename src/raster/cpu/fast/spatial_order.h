// SPDX-License-Identifier: MIT
//
// The order in which the fast pipeline keeps a scene: neighbours in it are mostly neighbours in
// space and of like size, so that blocks are compact. A block that holds one large Gaussian is seen
// from wherever that one is.
#pragma once

#include "raster/base/parallel.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::cpu::fast {

/// Indices of all Gaussians by class of size, those of a class along a Morton curve, those of a
/// cell ascending.
Array<std::uint32_t> spatial_order(const GaussianCloud& cloud, ThreadPool& pool);

}  // namespace qs::cpu::fast
