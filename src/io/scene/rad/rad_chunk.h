// SPDX-License-Identifier: MIT
//
// A chunk of a .rad file: a description in JSON and one plane of values per property, each perhaps
// deflated. Sizes are checked against the chunk's bytes before anything is allocated. To add a
// property or an encoding, add its row in rad_chunk.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "io/bytes/byte_cursor.h"
#include "io/bytes/json_value.h"
#include "raster/pages/lod_node.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

inline constexpr std::string_view kRadChunkMagic = "RADC";

/// The properties of a node. The three of kRadSh are the degrees 1 to 3; the three of kRadCodes are
/// tables, of which kRadLabel chooses a row.
enum RadKind : std::size_t {
  kRadCenter,
  kRadAlpha,
  kRadRgb,
  kRadScales,
  kRadOrientation,
  kRadSh,
  kRadCodes = kRadSh + 3,
  kRadLabel = kRadCodes + 3,
  kRadChildCount,
  kRadChildStart,
  kRadKinds
};

enum class RadCoding {
  f32,
  f16,
  f32_lebytes,  ///< all lowest bytes come first
  f16_lebytes,
  r8,        ///< a byte within min..max
  r8_delta,  ///< the difference to the byte before
  s8,        ///< a signed byte, 127 is max
  s8_delta,
  ln_f16,   ///< a logarithm
  ln_0r8,   ///< 0, or a logarithm within min..max
  oct88r8,  ///< two bytes of an octahedral axis and one of an angle, side by side
  u16,
  u32
};

struct RadProperty {
  RadCoding coding = RadCoding::f32;
  bool deflated = false;
  double min = 0, max = 0;
  std::uint64_t rows = 0;
  std::uint64_t needed = 0;  ///< bytes when inflated
  ByteSpan bytes;
};

struct RadChunk {
  std::string source;                 ///< for messages
  Array<std::byte> loaded;            ///< content of a file of its own, else empty
  std::uint64_t base = 0, count = 0;  ///< nodes
  std::array<std::optional<RadProperty>, kRadKinds> properties;
  ByteSpan own, original;            ///< the blocks of rad_writer.h, deflated; else empty
  std::uint64_t ignored_bytes = 0;   ///< after the properties
  std::vector<std::string> unknown;  ///< names of properties

  /// The highest degree of its properties and tables.
  int sh_degree() const;

  /// The property, which must be there: throws Error(input) otherwise.
  const RadProperty& get(std::size_t kind) const;
};

/// Reads `magic`, a length, JSON of that length with version 1, and zeros up to a multiple of 8.
/// Throws Error(input), as all functions here.
nlohmann::json read_rad_description(ByteCursor& cursor, std::string_view magic,
                                    const std::string& source);

/// The list of objects `key`.
const nlohmann::json& rad_list(const JsonEntry& entry, const char* key);

/// `content` must outlive the chunk. `code_count`: rows of its tables; unset: as many as nodes.
RadChunk parse_rad_chunk(ByteSpan content, const std::string& source,
                         std::optional<std::uint64_t> code_count);

/// Value k of row i is at k * rows + i. Scales with a coding ln_... stay logarithms; oct88r8 gives
/// its bytes, 0..255.
Array<float> rad_values(const RadChunk& chunk, std::size_t kind);

/// A property whose values are bytes of a table: byte k * rows + i for value k of row i.
struct RadBytes {
  Array<std::byte> bytes;
  std::array<float, 256> values;

  // Without the checks of other operators [], because pages have millions of values.
  float operator[](std::size_t i) const {
    return values.data()[std::to_integer<std::size_t>(bytes.data()[i])];
  }
};

/// Unset for codings of more than a byte. Has the same values as rad_values().
std::optional<RadBytes> rad_bytes(const RadChunk& chunk, std::size_t kind);

/// The children of all nodes of a chunk, and with `has_own` the values of the block of
/// rad_writer.h: gains to radius and the parent. Throws Error(input) if it is damaged or not there.
std::vector<LodFacts> rad_nodes(const RadChunk& chunk, bool has_own = true);

/// Values of kRadLabel, kRadChildCount or kRadChildStart.
std::vector<std::uint32_t> rad_integers(const RadChunk& chunk, std::size_t kind);

}  // namespace qs
