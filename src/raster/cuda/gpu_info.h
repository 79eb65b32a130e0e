// SPDX-License-Identifier: MIT
//
// Which GPUs there are, and why none can be used. Plain C++.
#pragma once

#include "raster/renderer.h"

namespace qs::cuda {

/// See qs::gpu_report().
GpuReport gpu_report();

}  // namespace qs::cuda
