// SPDX-License-Identifier: MIT
//
// Counts views in the statistics of adaptive density control.
#pragma once

#include "raster/cpu/train/parameters.h"

namespace qs::cpu::train {

using qs::train::DensityStatistics;

/// Adds a view of `width` x `height` pixels, with absolute gradients if `gradients` has them.
void add_view(const Gradients<float>& gradients, int width, int height,
              DensityStatistics& statistics);

}  // namespace qs::cpu::train
