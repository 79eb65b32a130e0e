// SPDX-License-Identifier: MIT
//
// Numbers of a few bits in consecutive bytes, as Compact-3DGS packs the codes of its Gaussians:
// each number's lowest bit first, each byte's highest bit first, zeros at the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Bytes that `count` numbers of `bits` bits take. `count * bits` does not overflow.
constexpr std::uint64_t packed_bytes(std::uint64_t count, int bits) {
  return (count * static_cast<std::uint64_t>(bits) + 7) / 8;
}

/// Every number of `packed`, which has packed_bytes(count, bits) bytes. bits: 1..16.
Array<std::uint16_t> unpack_bits(std::span<const std::byte> packed, std::size_t count, int bits);

/// Its inverse. Numbers are below 2^bits.
std::vector<std::byte> pack_bits(std::span<const std::uint16_t> numbers, int bits);

}  // namespace qs
