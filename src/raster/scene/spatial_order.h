// SPDX-License-Identifier: MIT
//
// The order in which the fast pipelines store a scene: neighbours are mostly close in space and of
// similar size, so that blocks are compact. One large Gaussian would make its whole block visible
// from far more views.
#pragma once

#include "base/parallel.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Indices of all Gaussians, sorted by size class, then cell on a Morton curve, then index.
Array<std::uint32_t> spatial_order(const GaussianCloud& cloud, ThreadPool& pool);

}  // namespace qs
