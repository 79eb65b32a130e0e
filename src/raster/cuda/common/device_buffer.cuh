// SPDX-License-Identifier: MIT
//
// Owned memory. A DeviceBuffer grows on demand and never shrinks, so that frames of varying size
// soon stop allocating; growing discards the contents. A PinnedValue is one host value that the GPU
// can write asynchronously.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "raster/cuda/common/check.cuh"

namespace qs::cuda {

struct DeviceMemory {
  std::size_t free = 0, total = 0;  ///< bytes

  static DeviceMemory now() {
    DeviceMemory memory;
    check(cudaMemGetInfo(&memory.free, &memory.total), "cudaMemGetInfo");
    return memory;
  }
};

/// Throws Error(device) if `needed` bytes for `what` exceed the free memory plus `held`, the bytes
/// that the caller frees first. Queries the driver only if `needed` exceeds `held`.
inline void require_memory(const char* what, std::uint64_t needed, std::uint64_t held) {
  if (needed <= held) return;
  const DeviceMemory memory = DeviceMemory::now();
  if (needed <= memory.free + held) return;
  const auto mebibytes = [](std::uint64_t bytes) { return std::to_string(bytes >> 20) + " MiB"; };
  throw Error(ErrorKind::device, std::string("cuda: ") + what + ": " + mebibytes(needed) +
                                     " are needed, " + mebibytes(memory.free + held) +
                                     " of the GPU's " + mebibytes(memory.total) + " are free");
}

/// `count` plus 25 % (at most `max`) if that takes less than half of the memory that is free or
/// `held`, else `count`: the next frame then rarely has to grow the buffers. `bytes_for(n)` is the
/// memory for n elements.
template <class BytesFor>
std::uint32_t with_headroom(std::uint64_t count, std::uint64_t max, std::uint64_t held,
                            const BytesFor& bytes_for) {
  const auto more = static_cast<std::uint32_t>(std::min(count + count / 4, max));
  const bool plenty = bytes_for(more) < (DeviceMemory::now().free + held) / 2;
  return plenty ? more : static_cast<std::uint32_t>(count);
}

/// Calls `work`. If that throws an Error, memory may be short: calls `make_room`, which frees what
/// can be copied or computed again, and then `work` once more. `make_room` returns false if it had
/// nothing to free; then the Error is thrown on.
template <class MakeRoom, class Work>
auto making_room(const MakeRoom& make_room, const Work& work) {
  try {
    return work();
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::device || !make_room()) throw;
  }
  return work();
}

template <class T>
class DeviceBuffer {
 public:
  DeviceBuffer() = default;
  DeviceBuffer(DeviceBuffer&& other) noexcept { swap(other); }
  DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
    swap(other);
    return *this;
  }
  ~DeviceBuffer() { cudaFree(data_); }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t capacity() const { return capacity_; }
  std::uint64_t bytes() const { return std::uint64_t{capacity_} * sizeof(T); }

  /// Makes room for `count` elements, with undefined values if it grows. `what` names them in the
  /// Error(device) that is thrown if memory is short; the buffer is then empty.
  void reserve(const char* what, std::size_t count) {
    if (count <= capacity_) return;
    const std::uint64_t needed = std::uint64_t{count} * sizeof(T);
    require_memory(what, needed, bytes());
    release();
    const cudaError_t error = cudaMalloc(&data_, needed);
    if (error == cudaErrorMemoryAllocation) {
      data_ = nullptr;
      cudaGetLastError();
      require_memory(what, needed, 0);  // throws the message with the sizes, if memory is short
    }
    check(error, what);
    capacity_ = count;
  }

  void release() {
    cudaFree(std::exchange(data_, nullptr));
    capacity_ = 0;
  }

  void swap(DeviceBuffer& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(capacity_, other.capacity_);
  }

 private:
  T* data_ = nullptr;
  std::size_t capacity_ = 0;
};

template <class T>
class PinnedValue {
 public:
  PinnedValue() { check(cudaMallocHost(&value_, sizeof(T)), "cudaMallocHost"); }
  PinnedValue& operator=(PinnedValue&&) = delete;
  ~PinnedValue() { cudaFreeHost(value_); }

  T* operator->() { return value_; }
  const T* operator->() const { return value_; }
  T& operator*() { return *value_; }

 private:
  T* value_ = nullptr;
};

}  // namespace qs::cuda
