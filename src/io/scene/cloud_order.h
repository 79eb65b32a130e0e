// SPDX-License-Identifier: MIT
//
// Orders of a cloud's Gaussians that files want, and choosing some of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Numbers of all Gaussians, those that cover most first: by opacity times the product of the two
/// largest standard deviations. Equal ones keep their order.
std::vector<std::uint32_t> largest_first(const GaussianCloud& cloud);

/// Numbers of all Gaussians along a Morton curve through the cloud's box: neighbours in the list
/// are mostly neighbours in space.
std::vector<std::uint32_t> morton_order(const GaussianCloud& cloud);

/// The Gaussians with these numbers, in this order.
GaussianCloud select(const GaussianCloud& cloud, std::span<const std::uint32_t> numbers);

/// The `count` largest Gaussians in their old order; all when there are no more than that.
GaussianCloud keep_largest(GaussianCloud cloud, std::size_t count);

}  // namespace qs
