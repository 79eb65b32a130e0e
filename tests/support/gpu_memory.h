// SPDX-License-Identifier: MIT
//
// Arrays in the memory of the GPU, for tests that g++ compiles. Copies wait.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace qs::test {

/// Throws Error(device) if memory is short.
class GpuMemory {
 public:
  GpuMemory() = default;
  explicit GpuMemory(std::size_t bytes);
  GpuMemory(GpuMemory&& other) noexcept { swap(other); }
  GpuMemory& operator=(GpuMemory&& other) noexcept {
    swap(other);
    return *this;
  }
  ~GpuMemory();

  void* data() const { return data_; }
  std::size_t bytes() const { return bytes_; }
  /// The whole block.
  void upload(const void* from);
  void download(void* to) const;
  /// Sets every byte.
  void fill(int byte);

 private:
  void swap(GpuMemory& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(bytes_, other.bytes_);
  }
  void* data_ = nullptr;
  std::size_t bytes_ = 0;
};

template <class T>
class GpuArray {
 public:
  GpuArray() = default;
  /// With this byte everywhere, so that values that nobody writes are found.
  explicit GpuArray(std::size_t count, int byte = 0x7f) : memory_(count * sizeof(T)) {
    memory_.fill(byte);
  }
  explicit GpuArray(const std::vector<T>& values) : memory_(values.size() * sizeof(T)) {
    memory_.upload(values.data());
  }
  T* data() const { return static_cast<T*>(memory_.data()); }
  std::vector<T> values() const {
    std::vector<T> result(memory_.bytes() / sizeof(T));
    memory_.download(result.data());
    return result;
  }

 private:
  GpuMemory memory_;
};

}  // namespace qs::test
