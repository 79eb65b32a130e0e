// SPDX-License-Identifier: MIT
//
// Limits of the current device, from which grids and buffers get their sizes. Throws Error(device).
#pragma once

namespace qs::cuda {

/// Multiprocessors. Kernels whose blocks share their work start a few blocks for each.
unsigned multiprocessors();

}  // namespace qs::cuda
