// SPDX-License-Identifier: MIT
//
// Memory that this process shares with a child process: an anonymous file, mapped in both.
#pragma once

#include <cstddef>

#include "base/descriptor.h"

namespace qs {

/// A mapping of a whole file.
class Mapping {
 public:
  Mapping() = default;
  /// Throws Error(device).
  Mapping(int descriptor, std::size_t bytes);
  ~Mapping();
  Mapping(Mapping&& other) noexcept;
  Mapping& operator=(Mapping&& other) noexcept;

  std::size_t size() const { return bytes_; }
  std::byte* data() const { return data_; }
  float* floats(std::size_t offset_bytes = 0) const {
    return reinterpret_cast<float*>(data_ + offset_bytes);
  }

 private:
  std::byte* data_ = nullptr;
  std::size_t bytes_ = 0;
};

/// The file with its mapping in this process.
class SharedMemory {
 public:
  /// Empty. Throws Error(device).
  SharedMemory();

  /// Makes the file `bytes` long and maps it; new bytes are 0. Throws Error(device).
  void resize(std::size_t bytes);

  int descriptor() const { return file_.get(); }
  const Mapping& mapping() const { return mapping_; }

 private:
  Descriptor file_;
  Mapping mapping_;
};

}  // namespace qs
