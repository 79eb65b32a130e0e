// SPDX-License-Identifier: MIT
//
// The scene as the fast pipeline keeps it: in spatial order, with what tells quickly which blocks a
// view cannot show.
#pragma once

#include "raster/cpu/fast/frustum.h"

namespace qs::cpu::fast {

struct Scene {
  Array<Block> blocks;
  Array<BlockBounds> bounds;  ///< per block
  Harmonics harmonics;
};

Scene make_scene(const GaussianCloud& cloud, const ActivatedCloud& active, ThreadPool& pool);

}  // namespace qs::cpu::fast
