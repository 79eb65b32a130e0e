// SPDX-License-Identifier: MIT
//
// The tiles that the culling modes list in device code, without a renderer around them.
#pragma once

#include <set>
#include <vector>

#include "raster/kernel/cull/mode.h"
#include "support/cull_vectors.h"

namespace qs::test {

/// The tiles that `mode`, 1..mode_count(), lists for each vector's footprint on the current GPU.
/// Throws Error(device).
std::vector<std::set<int>> tiles_on_gpu(CullMode mode, const std::vector<CullVector>& vectors);

}  // namespace qs::test
