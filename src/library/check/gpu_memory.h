// SPDX-License-Identifier: MIT
//
// Memory of the GPU for a call, in the order of its stream. Only for code that is built with CUDA.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/not_copied.h"
#include "learn/diff/cuda/device.h"
#include "library/check/frame_memory.h"

namespace qs::library {

/// Memory of the caller. Throws Error(usage) unless it is the GPU's.
void* allocate_on_gpu(const CallersMemory& memory, std::size_t bytes, std::uint32_t kind);

/// Temporary memory of a call: from the caller, or of the library until the call returns.
class Temporary : NotCopied {
 public:
  /// `memory`: the caller's; null: none. Throws Error(usage).
  Temporary(const Where& where, const QsMemory* memory, const cuda::diff::Queue& queue)
      : queue_(queue) {
    if (memory != nullptr) callers_.emplace(where, memory);
  }
  ~Temporary() {
    for (void* const block : own_) cuda::diff::free(block, queue_);
  }

  /// Null for 0 bytes.
  void* allocate(std::size_t bytes);

  template <class T>
  T* numbers(std::size_t count) {
    return static_cast<T*>(allocate(count * sizeof(T)));
  }

 private:
  const cuda::diff::Queue& queue_;
  std::optional<CallersMemory> callers_;
  std::vector<void*> own_;
};

}  // namespace qs::library
