// SPDX-License-Identifier: MIT
//
// Counts the tile pairs of every mode for one view: Outputs::mode_pairs.
#pragma once

#include "raster/cpu/common/mode_pairs.h"
#include "raster/scene/activated_cloud.h"

namespace qs::cpu {

/// Adds the counts of all Gaussians to `sums`.
void count_modes(const FrameContext& frame, const ActivatedCloud& active, ModeSums& sums);

}  // namespace qs::cpu
