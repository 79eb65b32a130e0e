// SPDX-License-Identifier: MIT
//
// Orders of Gaussians that file formats and the fast pipelines require, and selection of Gaussians.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Indices of all Gaussians, largest first: by opacity times the product of the two largest
/// standard deviations. Gaussians of equal size keep their order.
std::vector<std::uint32_t> largest_first(const GaussianCloud& cloud);

/// Indices of all Gaussians along a Morton curve through the cloud's bounding box: neighbours in
/// the list are mostly neighbours in space.
std::vector<std::uint32_t> morton_order(const GaussianCloud& cloud);

/// The Gaussians with these indices, in this order.
GaussianCloud select(const GaussianCloud& cloud, std::span<const std::uint32_t> numbers);

/// The `count` largest Gaussians in their old order; all Gaussians if the cloud has at most
/// `count`.
GaussianCloud keep_largest(GaussianCloud cloud, std::size_t count);

/// The order in which the fast pipelines store a scene: neighbours are mostly close in space and of
/// similar size, so that blocks are compact. One large Gaussian would make its whole block visible
/// from far more views. Indices of all Gaussians, sorted by size class, then cell on a Morton
/// curve, then index.
Array<std::uint32_t> spatial_order(const GaussianCloud& cloud, ThreadPool& pool);

}  // namespace qs
