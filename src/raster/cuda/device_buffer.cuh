// SPDX-License-Identifier: MIT
//
// Owned memory. A DeviceBuffer grows on demand and never shrinks, so that frames of changing size
// soon stop allocating; growing does not keep the contents. A PinnedValue is one host value that
// the GPU writes while the host works on.
#pragma once

#include <cstdint>
#include <utility>

#include "raster/cuda/check.cuh"

namespace qs::cuda {

struct DeviceMemory {
  std::size_t free = 0, total = 0;  ///< bytes

  static DeviceMemory now() {
    DeviceMemory memory;
    check(cudaMemGetInfo(&memory.free, &memory.total), "cudaMemGetInfo");
    return memory;
  }
};

/// Throws Error(device) when `needed` bytes for `what` are more than what is free now and `held`,
/// the bytes that are going to be freed for it. Asks the driver only when something must grow.
inline void require_memory(const char* what, std::uint64_t needed, std::uint64_t held) {
  if (needed <= held) return;
  const DeviceMemory memory = DeviceMemory::now();
  if (needed <= memory.free + held) return;
  const auto mebibytes = [](std::uint64_t bytes) { return std::to_string(bytes >> 20) + " MiB"; };
  throw Error(ErrorKind::device, std::string("cuda: ") + what + ": " + mebibytes(needed) +
                                     " are needed, " + mebibytes(memory.free + held) +
                                     " of the GPU's " + mebibytes(memory.total) + " are free");
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

  /// Room for `count` elements of undefined value; `what` names them in the Error. After an Error
  /// the buffer is empty.
  void reserve(const char* what, std::size_t count) {
    if (count <= capacity_) return;
    const std::uint64_t needed = std::uint64_t{count} * sizeof(T);
    require_memory(what, needed, bytes());
    release();
    const cudaError_t error = cudaMalloc(&data_, needed);
    if (error == cudaErrorMemoryAllocation) {
      data_ = nullptr;
      cudaGetLastError();
      require_memory(what, needed, 0);  // the sentence with the numbers, unless they look fine
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
  PinnedValue(const PinnedValue&) = delete;
  PinnedValue& operator=(const PinnedValue&) = delete;
  ~PinnedValue() { cudaFreeHost(value_); }

  T* operator->() { return value_; }
  T& operator*() { return *value_; }

 private:
  T* value_ = nullptr;
};

}  // namespace qs::cuda
