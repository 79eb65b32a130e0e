// SPDX-License-Identifier: MIT
//
// Arrays one after the other in a block of memory of the caller, at multiples of kBlockAlignment
// bytes.
#pragma once

#include <cstddef>

namespace qs::diff {

inline constexpr std::size_t kBlockAlignment = 16;

/// Distributes a block to arrays. Without memory it counts the bytes alone.
class BlockArrays {
 public:
  explicit BlockArrays(void* memory) : memory_(static_cast<std::byte*>(memory)) {}

  template <class T>
  T* next(std::size_t count) {
    const std::size_t at = bytes_;
    bytes_ += (count * sizeof(T) + kBlockAlignment - 1) / kBlockAlignment * kBlockAlignment;
    return memory_ == nullptr ? nullptr : reinterpret_cast<T*>(memory_ + at);
  }
  std::size_t bytes() const { return bytes_; }

 private:
  std::byte* memory_;
  std::size_t bytes_ = 0;
};

/// `Block::of(arrays, sizes)` takes the arrays of a block from BlockArrays.
template <class Block, class Sizes>
std::size_t bytes_of(const Sizes& sizes) {
  BlockArrays counted(nullptr);
  Block::of(counted, sizes);
  return counted.bytes();
}

/// A block in memory of at least bytes_of() bytes.
template <class Block, class Sizes>
Block block_at(void* memory, const Sizes& sizes) {
  BlockArrays arrays(memory);
  return Block::of(arrays, sizes);
}

}  // namespace qs::diff
