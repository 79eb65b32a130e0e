// SPDX-License-Identifier: MIT
//
// The GPU of a caller for code that g++ compiles: its selection, memory in the order of a stream,
// and copies, also of a frame's maps. All functions throw Error(device).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "learn/diff/cuda/frame.h"
#include "learn/diff/strided_arrays.h"

namespace qs::cuda::diff {

/// Selects a GPU for this thread, for the lifetime of the object.
class SelectedGpu {
 public:
  explicit SelectedGpu(int device);
  ~SelectedGpu();
  SelectedGpu& operator=(SelectedGpu&&) = delete;

 private:
  int before_ = 0;
  bool is_other_ = false;
};

/// True if the selected GPU can read and write the memory.
bool is_gpu_memory(const void* memory);

/// The number of the GPU that has the memory, if it is not `device`. nullopt for memory that CUDA
/// does not know, and if the machine has no such device.
std::optional<int> other_gpu_of(const void* memory, int device);

/// Memory that work in the stream may use until it is freed, in the order of the stream.
void* allocate(std::size_t bytes, const Queue& queue);
void free(void* memory, const Queue& queue) noexcept;

/// Enqueues a copy to the GPU; `from` may change when the function returns.
void copy_to_gpu(void* to, const void* from, std::size_t bytes, const Queue& queue);
/// Waits.
void copy_from_gpu(void* to, const void* from, std::size_t bytes, const Queue& queue);
/// Waits for all work in the stream.
void wait(const Queue& queue);
/// Enqueues a copy within the GPU.
void copy_on_gpu(void* to, const void* from, std::size_t bytes, const Queue& queue);

/// A map of height x width x channels values on the GPU, one after the other.
struct PackedMap {
  const float* values;
  int height, width, channels;
};

/// Enqueues a copy into an array on the GPU, also as 8 bits by to_8bit() of image.h.
void store_map(const PackedMap& map, const qs::diff::Pixels<float>& to, const Queue& queue);
void store_map(const PackedMap& map, const qs::diff::Pixels<std::uint8_t>& to, const Queue& queue);

}  // namespace qs::cuda::diff
