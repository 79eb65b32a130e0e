// SPDX-License-Identifier: MIT
#ifdef QUADSPLAT_HAVE_CUDA
#include "library/check/gpu_memory.h"

namespace qs::library {

namespace gpu = cuda::diff;

void* allocate_on_gpu(const CallersMemory& memory, std::size_t bytes, std::uint32_t kind) {
  void* const block = memory.allocate(bytes, kind);
  if (!gpu::is_gpu_memory(block)) memory.refuse_memory("returned memory that is not the GPU's");
  return block;
}

void* Temporary::allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  if (callers_) return allocate_on_gpu(*callers_, bytes, QS_TEMPORARY);
  own_.reserve(own_.size() + 1);
  return own_.emplace_back(gpu::allocate(bytes, queue_));
}

}  // namespace qs::library
#endif
