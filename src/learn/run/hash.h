// SPDX-License-Identifier: MIT
//
// FNV-1a with 64 bits (Fowler, Noll and Vo): it detects damage and changed data, but not attacks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace qs::train {

/// Continues `hash` with more bytes.
inline std::uint64_t hash_of(std::span<const std::byte> bytes,
                             std::uint64_t hash = 0xcbf29ce484222325) {
  for (const std::byte byte : bytes)
    hash = (hash ^ static_cast<std::uint64_t>(byte)) * 0x100000001b3;
  return hash;
}

}  // namespace qs::train
