// SPDX-License-Identifier: MIT
//
// Memory of a GPU for plugins that draw on it. It uses CUDA's driver, loaded when it is first
// needed, so that a program built without CUDA can measure plugins that use it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace qs {

class DeviceMemory {
 public:
  /// Makes the primary context of a GPU current in this thread. Throws Error(device) without a
  /// driver or such a GPU.
  explicit DeviceMemory(int device);
  /// Frees all memory.
  ~DeviceMemory();
  DeviceMemory(const DeviceMemory&) = delete;
  DeviceMemory& operator=(const DeviceMemory&) = delete;

  /// Addresses in device memory, as CUDA's runtime accepts them. They throw Error(device).
  void* allocate(std::size_t bytes);
  void* copied(const void* host, std::size_t bytes);
  void free(void* memory);
  void fill(void* memory, std::uint8_t value, std::size_t bytes);
  void copy_to_host(const void* memory, void* host, std::size_t bytes);

 private:
  struct Driver;
  std::unique_ptr<Driver> driver_;
};

}  // namespace qs
