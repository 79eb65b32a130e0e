// SPDX-License-Identifier: MIT
//
// The scene in the layout of the fast pipeline: blocks in spatial order, with bounds that let a
// view skip whole blocks.
#pragma once

#include "raster/cpu/fast/blocks.h"
#include "raster/kernel/frustum.h"

namespace qs::cpu::fast {

struct SceneBlocks {
  Array<Block> blocks;
  Array<BlockBounds> bounds;  ///< per block
  Harmonics harmonics;
};

SceneBlocks make_scene(const GaussianCloud& cloud, ThreadPool& pool);

}  // namespace qs::cpu::fast
