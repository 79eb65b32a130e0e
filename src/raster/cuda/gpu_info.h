// SPDX-License-Identifier: MIT
//
// Lists the GPUs, or says why none can be used. Plain C++.
#pragma once

#include "raster/renderer.h"

namespace qs::cuda {

/// See qs::gpu_report().
GpuReport gpu_report();

}  // namespace qs::cuda
