// SPDX-License-Identifier: MIT
//
// Morton codes: they number the cells of a grid along a curve, so that cells with close numbers are
// mostly close in space.
#pragma once

#include <cstdint>

namespace qs {

/// Inserts two zero bits between neighbours of the lower 21 bits of `value`.
constexpr std::uint64_t spread_bits(std::uint64_t value) {
  value &= 0x1fffff;
  value = (value | value << 32) & 0x1f00000000ffff;
  value = (value | value << 16) & 0x1f0000ff0000ff;
  value = (value | value << 8) & 0x100f00f00f00f00f;
  value = (value | value << 4) & 0x10c30c30c30c30c3;
  return (value | value << 2) & 0x1249249249249249;
}

/// Code of a cell. Coordinates of n <= 21 bits give a code of 3 n bits.
constexpr std::uint64_t morton_code(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  return spread_bits(x) | spread_bits(y) << 1 | spread_bits(z) << 2;
}

}  // namespace qs
