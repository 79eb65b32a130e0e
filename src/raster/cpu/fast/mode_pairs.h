// SPDX-License-Identifier: MIT
//
// Counts the tile pairs of every mode for one view, by vectors: Outputs::mode_pairs.
#pragma once

#include "raster/cpu/common/mode_pairs.h"
#include "raster/cpu/fast/scene.h"

namespace qs::cpu::fast {

/// Adds the counts of all Gaussians to `sums`. `scene` was made of frame.cloud.
void count_modes(const FrameContext& frame, const SceneBlocks& scene, ModeSums& sums);

}  // namespace qs::cpu::fast
