// SPDX-License-Identifier: MIT
//
// Morton codes: numbers of the cells of a grid along a curve on which neighbours are mostly
// neighbours in space.
#pragma once

#include <cstdint>

namespace qs {

/// The lower 21 bits of `value` with two zeros between neighbours.
constexpr std::uint64_t spread_bits(std::uint64_t value) {
  value &= 0x1fffff;
  value = (value | value << 32) & 0x1f00000000ffff;
  value = (value | value << 16) & 0x1f0000ff0000ff;
  value = (value | value << 8) & 0x100f00f00f00f00f;
  value = (value | value << 4) & 0x10c30c30c30c30c3;
  return (value | value << 2) & 0x1249249249249249;
}

/// Of a cell whose coordinates have at most 21 bits each; three times as many bits as those have.
constexpr std::uint64_t morton_code(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  return spread_bits(x) | spread_bits(y) << 1 | spread_bits(z) << 2;
}

}  // namespace qs
