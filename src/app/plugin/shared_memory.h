// SPDX-License-Identifier: MIT
//
// Memory that this process shares with a child process: an anonymous file, mapped in both.
#pragma once

#include <cstddef>
#include <memory>

#include "base/descriptor.h"

namespace qs {

/// A mapping of a whole file.
class Mapping {
 public:
  Mapping() = default;
  /// Throws Error(device).
  Mapping(int descriptor, std::size_t bytes);

  std::size_t size() const { return data_ ? data_.get_deleter().bytes : 0; }
  std::byte* data() const { return data_.get(); }
  float* floats(std::size_t offset_bytes = 0) const {
    return reinterpret_cast<float*>(data() + offset_bytes);
  }

 private:
  struct Unmap {
    std::size_t bytes;
    void operator()(std::byte* data) const;
  };
  std::unique_ptr<std::byte, Unmap> data_;
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
