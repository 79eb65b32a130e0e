// SPDX-License-Identifier: MIT
//
// Huffman codes as dahuffman writes them: a table of symbols with the number of bits and the value
// of their codes, and a stream of codes, highest bit first. An end symbol, or as many of its first
// bits as fit, fills the last byte if it is not full.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/bytes/byte_text.h"
#include "io/tensor/pickle.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// The end symbol; all others are below.
constexpr std::uint32_t kHuffmanEnd = 1u << 16;

struct HuffmanCode {
  std::uint32_t symbol = 0;  ///< 0..65535 or kHuffmanEnd
  int bits = 0;              ///< 1..64
  std::uint64_t value = 0;
};

/// The table that is a dictionary of a pickle: whole numbers, also as reals, and one end symbol.
/// Messages begin with `source`. Throws Error(input).
std::vector<HuffmanCode> read_huffman_table(const Pickle& pickle, PickleRef table,
                                            const std::string& source);

/// The shortest codes for symbols that occur as often as `counts` says, and for one end symbol.
/// Symbols that do not occur have none.
std::vector<HuffmanCode> make_huffman_table(std::span<const std::uint64_t> counts);

/// The stream of codes of `symbols`, which all are in the table.
std::vector<std::byte> huffman_encode(std::span<const HuffmanCode> table,
                                      std::span<const std::uint16_t> symbols);

class HuffmanDecoder {
 public:
  /// Throws Error(input) if a code begins another code. Messages begin with `source`.
  HuffmanDecoder(std::span<const HuffmanCode> table, std::string source);

  /// All symbols of a stream. Throws Error(input) if it has more than `most` or is damaged.
  Array<std::uint16_t> decode(ByteSpan stream, std::uint64_t most) const;

 private:
  static constexpr int kFastBits = 11;

  // The state after some bits: a symbol, another node, or nothing that the table knows.
  struct Step {
    std::uint32_t to = 0;   // kLeaf + symbol, or a node; 0: no code begins so
    std::uint8_t bits = 0;  // that were read
  };
  static constexpr std::uint32_t kLeaf = 1u << 31;

  void insert(const HuffmanCode& code);
  void fill_fast();

  std::string source_;
  std::vector<std::array<std::uint32_t, 2>> nodes_;  // children as Step::to; node 0 is the root
  std::vector<Step> fast_;                           // index: the next kFastBits bits
};

// Numbers of a few bits in consecutive bytes, as Compact-3DGS packs the codes of its Gaussians:
// each number's lowest bit first, each byte's highest bit first, zeros at the end.

/// Bytes that `count` numbers of `bits` bits take. `count * bits` does not overflow.
constexpr std::uint64_t packed_bytes(std::uint64_t count, int bits) {
  return (count * static_cast<std::uint64_t>(bits) + 7) / 8;
}

/// Every number of `packed`, which has packed_bytes(count, bits) bytes. bits: 1..16.
Array<std::uint16_t> unpack_bits(ByteSpan packed, std::size_t count, int bits);

/// Its inverse. Numbers are below 2^bits.
std::vector<std::byte> pack_bits(std::span<const std::uint16_t> numbers, int bits);

}  // namespace qs
