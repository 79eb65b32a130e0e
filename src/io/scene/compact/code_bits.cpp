// SPDX-License-Identifier: MIT
#include "io/scene/compact/code_bits.h"

#include <cassert>

namespace qs {

Array<std::uint16_t> unpack_bits(std::span<const std::byte> packed, std::size_t count, int bits) {
  assert(packed.size() >= packed_bytes(count, bits));
  Array<std::uint16_t> numbers(count);
  std::size_t next = 0;
  for (std::uint16_t& number : numbers) {
    unsigned value = 0;
    for (int bit = 0; bit < bits; ++bit, ++next) {
      const unsigned set = std::to_integer<unsigned>(packed[next / 8]) >> (7 - next % 8) & 1;
      value |= set << bit;
    }
    number = static_cast<std::uint16_t>(value);
  }
  return numbers;
}

std::vector<std::byte> pack_bits(std::span<const std::uint16_t> numbers, int bits) {
  std::vector<std::byte> packed(packed_bytes(numbers.size(), bits));
  std::size_t next = 0;
  for (const std::uint16_t number : numbers) {
    for (int bit = 0; bit < bits; ++bit, ++next) {
      if ((number >> bit & 1) != 0)
        packed[next / 8] |= std::byte{0x80} >> static_cast<int>(next % 8);
    }
  }
  return packed;
}

}  // namespace qs
