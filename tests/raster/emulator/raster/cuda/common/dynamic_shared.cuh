// SPDX-License-Identifier: MIT
//
// Replaces the header of the same name: g++ has no dynamic shared memory.
#pragma once

#include "cuda_runtime.h"

namespace qs::cuda {

inline void* dynamic_shared() { return emulator::dynamic_shared.data(); }

}  // namespace qs::cuda
