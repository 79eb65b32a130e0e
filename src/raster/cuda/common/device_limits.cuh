// SPDX-License-Identifier: MIT
//
// Limits of the current device, from which grids and buffers get their sizes. Throws Error(device).
#pragma once

namespace qs::cuda {

/// The number of multiprocessors. Kernels whose blocks share work start a few blocks for each.
unsigned multiprocessors();

}  // namespace qs::cuda
