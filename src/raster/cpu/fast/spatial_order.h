// SPDX-License-Identifier: MIT
//
// The order in which the fast pipeline keeps a scene: neighbours in it are mostly neighbours in
// space, so that blocks are compact and what a tile reads lies together.
#pragma once

#include <span>

#include "raster/scene/gaussian_cloud.h"
#include "raster/scene/parallel.h"

namespace qs::cpu::fast {

/// Indices of all positions along a Morton curve; those of one cell ascend.
Array<std::uint32_t> spatial_order(std::span<const glm::vec3> positions, ThreadPool& pool);

}  // namespace qs::cpu::fast
