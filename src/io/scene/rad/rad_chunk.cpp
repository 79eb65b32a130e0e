// SPDX-License-Identifier: MIT
#include "io/scene/rad/rad_chunk.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include <libdeflate.h>

#include "base/text.h"
#include "io/bytes/inflate.h"
#include "raster/kernel/half.h"

namespace qs {
namespace {

// Deflate alone would permit a thousand, which fill a machine's memory with a small file.
constexpr std::uint64_t kMaxRowsPerByte = 8;

struct CodingRow {
  std::string_view name;
  std::uint64_t bytes;  // per value
  bool has_min, has_max;
};
constexpr std::array<CodingRow, 13> kCodings = {{
    {"f32", 4, false, false},
    {"f16", 2, false, false},
    {"f32_lebytes", 4, false, false},
    {"f16_lebytes", 2, false, false},
    {"r8", 1, true, true},
    {"r8_delta", 1, true, true},
    {"s8", 1, false, true},
    {"s8_delta", 1, false, true},
    {"ln_f16", 2, false, false},
    {"ln_0r8", 1, true, true},
    {"oct88r8", 1, false, false},
    {"u16", 2, false, false},
    {"u32", 4, false, false},
}};

struct PropertyRow {
  std::string_view name;
  std::uint64_t values;  // per node
  std::string_view codings;
};
constexpr std::string_view kShCodings = "f32 f16 s8 s8_delta r8 r8_delta";
constexpr std::array<PropertyRow, kRadKinds> kProperties = {{
    {"center", 3, "f32 f16 f32_lebytes f16_lebytes"},
    {"alpha", 1, "f32 f16 r8"},
    {"rgb", 3, "f32 f16 r8 r8_delta"},
    {"scales", 3, "f32 ln_f16 ln_0r8"},
    {"orientation", 3, "f32 f16 oct88r8"},
    {"sh1", 9, kShCodings},
    {"sh2", 15, kShCodings},
    {"sh3", 21, kShCodings},
    {"sh1_code", 9, kShCodings},
    {"sh2_code", 15, kShCodings},
    {"sh3_code", 21, kShCodings},
    {"sh_label", 1, "u16 u32"},
    {"child_count", 1, "u16"},
    {"child_start", 1, "u32"},
}};

RadProperty parse_property(const JsonEntry& entry, const PropertyRow& row, ByteSpan bytes,
                           std::uint64_t rows) {
  const std::string& name = entry.text("encoding");
  const auto* const coding = std::ranges::find(kCodings, name, &CodingRow::name);
  if (coding == kCodings.end() || std::ranges::count(separated(row.codings, ' '), name) == 0)
    fail("{}: the encoding '{}' cannot be read; there are: {}", entry.where, printable(name),
         row.codings);
  RadProperty property{.rows = rows, .bytes = bytes};
  property.coding = static_cast<RadCoding>(coding - kCodings.begin());
  property.needed = row.values * coding->bytes * rows;  // far below 2^64
  if (coding->has_min) property.min = entry.number("min");
  if (coding->has_max) property.max = entry.number("max");
  property.deflated = entry.has("compression");
  if (property.deflated && entry.text("compression") != "gz")
    fail("{}: the compression '{}' is not known", entry.where,
         printable(entry.text("compression")));
  if (!property.deflated && property.needed != bytes.size())
    fail("{}: {} bytes for {} values, which take {}", entry.where, bytes.size(), row.values * rows,
         property.needed);
  return property;
}

// The bytes of a property. `room` receives them if they are deflated.
ByteSpan unpacked(const RadChunk& chunk, std::size_t kind, Array<std::byte>& room) {
  const RadProperty& property = chunk.get(kind);
  if (!property.deflated) return property.bytes;
  room.resize(property.needed);
  inflate_all(property.bytes, room, fmt::format("{}: {}", chunk.source, kProperties[kind].name));
  return ByteSpan(room);
}

}  // namespace

int RadChunk::sh_degree() const {
  int degree = 3;
  for (; degree > 0; --degree)
    if (properties[kRadSh + degree - 1] || properties[kRadCodes + degree - 1]) break;
  return degree;
}

const RadProperty& RadChunk::get(std::size_t kind) const {
  if (!properties[kind]) fail("{}: it has no {}", source, kProperties[kind].name);
  return *properties[kind];
}

nlohmann::json read_rad_description(ByteCursor& cursor, std::string_view magic,
                                    const std::string& source) {
  if (text_of(cursor.take(magic.size(), "the magic word")) != magic)
    fail("{}: does not begin with '{}'", source, magic);
  const auto bytes = cursor.read<std::uint32_t>("the header");
  auto description = parse_json(text_of(cursor.take(bytes, "the description")), source);
  if (!description.is_object()) fail("{}: its description is not an object", source);
  cursor.take((8 - bytes % 8) % 8, "the end of the description");
  if (const auto version = JsonEntry{description, source}.whole("version"); version != 1)
    fail("{}: version {}, only 1 exists", source, version);
  return description;
}

const nlohmann::json& rad_list(const JsonEntry& entry, const char* key) {
  const nlohmann::json& list = entry.get(key);
  if (!list.is_array()) fail("{}: {} is not a list", entry.where, key);
  for (const nlohmann::json& each : list)
    if (!each.is_object()) fail("{}: {} has something else than objects", entry.where, key);
  return list;
}

RadChunk parse_rad_chunk(ByteSpan content, const std::string& source,
                         std::optional<std::uint64_t> code_count) {
  RadChunk chunk;
  chunk.source = source;
  ByteCursor cursor(content, source);
  const nlohmann::json description = read_rad_description(cursor, kRadChunkMagic, source);
  const JsonEntry entry{description, source};
  chunk.base = entry.whole("base");
  chunk.count = entry.whole("count");
  const auto payload_bytes = cursor.read<std::uint64_t>("the payload's size");
  const ByteSpan payload = cursor.take(payload_bytes, "the payload");
  std::uint64_t end = 0;  // of the properties so far
  for (const nlohmann::json& each : rad_list(entry, "properties")) {
    const std::string& name = JsonEntry{each, source}.text("property");
    const JsonEntry stored{each, fmt::format("{}: {}", source, printable(name))};
    const std::uint64_t offset = stored.whole("offset"), bytes = stored.whole("bytes");
    if (offset != end)
      fail("{}: offset is {}, but the property before ends at {}", stored.where, offset, end);
    if (end > payload.size() || bytes > payload.size() - end)
      fail("{}: cut off: {} bytes at offset {} of {}", stored.where, bytes, end, payload.size());
    const ByteSpan part = payload.subspan(end, bytes);
    end += (bytes + 7) / 8 * 8;
    const auto* const row = std::ranges::find(kProperties, name, &PropertyRow::name);
    if (row == kProperties.end()) {
      chunk.unknown.push_back(printable(name));
      continue;
    }
    const auto kind = static_cast<std::size_t>(row - kProperties.begin());
    if (chunk.properties[kind]) fail("{}: is there twice", stored.where);
    const bool is_table = kind >= kRadCodes && kind < kRadLabel;
    const std::uint64_t rows = is_table ? code_count.value_or(chunk.count) : chunk.count;
    if (rows > kMaxRowsPerByte * content.size())
      fail("{}: {} rows, but the chunk has only {} bytes", stored.where, rows, content.size());
    chunk.properties[kind] = parse_property(stored, *row, part, rows);
  }
  if (entry.has("quadsplat")) {
    const auto block = [&](const JsonEntry& place) {
      const std::uint64_t offset = place.whole("offset"), bytes = place.whole("bytes");
      if (offset != end || end > payload.size() || bytes > payload.size() - end)
        fail("{}: {} bytes at offset {} of {}", place.where, bytes, offset, payload.size());
      const ByteSpan stored = payload.subspan(end, bytes);
      if (libdeflate_crc32(0, stored.data(), stored.size()) != place.whole("crc32"))
        fail("{}: damaged: its checksum is wrong", place.where);
      end += (bytes + 7) / 8 * 8;
      return stored;
    };
    const JsonEntry own{entry.get("quadsplat"), source + ": quadsplat"};
    chunk.own = block(own);
    if (own.has("original"))
      chunk.original = block({own.get("original"), own.where + ": original"});
  }
  chunk.ignored_bytes =
      payload.size() - std::min<std::uint64_t>(end, payload.size()) + cursor.left();
  for (std::size_t kind = 0; kind < kRadSh; ++kind) chunk.get(kind);  // these must be there
  return chunk;
}

std::optional<RadBytes> rad_bytes(const RadChunk& chunk, std::size_t kind) {
  const RadProperty& property = chunk.get(kind);
  if (kCodings[static_cast<std::size_t>(property.coding)].bytes != 1 ||
      property.coding == RadCoding::oct88r8)
    return {};
  const double min = property.min, max = property.max;
  const auto value = [&](std::size_t byte) {
    switch (property.coding) {
      case RadCoding::s8:
      case RadCoding::s8_delta:
        return static_cast<std::int8_t>(byte) / 127.0 * max;
      case RadCoding::ln_0r8:
        return byte == 0 ? -std::numeric_limits<double>::infinity()
                         : min + (static_cast<double>(byte) - 1) * (max - min) / 254;
      default:
        return min + static_cast<double>(byte) * (max - min) / 255;
    }
  };
  RadBytes result;
  const ByteSpan stored = unpacked(chunk, kind, result.bytes);
  if (!property.deflated) result.bytes.assign(stored.begin(), stored.end());
  for (std::size_t i = 0; i < result.values.size(); ++i)
    result.values[i] = static_cast<float>(value(i));
  const auto added = [](std::byte a, std::byte b) {
    return static_cast<std::byte>(std::to_integer<unsigned>(a) + std::to_integer<unsigned>(b));
  };
  if (property.coding == RadCoding::r8_delta || property.coding == RadCoding::s8_delta)
    for (std::size_t begin = 0; begin < result.bytes.size(); begin += property.rows)
      std::partial_sum(&result.bytes[begin], &result.bytes[begin] + property.rows,
                       &result.bytes[begin], added);  // differences to the byte before
  return result;
}

Array<float> rad_values(const RadChunk& chunk, std::size_t kind) {
  const RadProperty& property = chunk.get(kind);
  const std::size_t rows = property.rows, count = kProperties[kind].values * rows;
  Array<float> values(count);
  const auto fill = [&](const auto& value) {
    for (std::size_t i = 0; i < count; ++i) values[i] = value(i);
  };
  if (const auto bytes = rad_bytes(chunk, kind)) {
    fill([&](std::size_t i) { return (*bytes)[i]; });
    return values;
  }
  Array<std::byte> room;
  const ByteSpan bytes = unpacked(chunk, kind, room);
  switch (property.coding) {
    case RadCoding::f32:
      fill([&](std::size_t i) { return load<float>(&bytes[4 * i]); });
      break;
    case RadCoding::f16:
    case RadCoding::ln_f16:
      fill([&](std::size_t i) { return float_of_any_half(load<std::uint16_t>(&bytes[2 * i])); });
      break;
    case RadCoding::f32_lebytes:
      fill([&](std::size_t i) {
        return load<float>(
            std::array{bytes[i], bytes[i + count], bytes[i + 2 * count], bytes[i + 3 * count]}
                .data());
      });
      break;
    case RadCoding::f16_lebytes:
      fill([&](std::size_t i) {
        return float_of_any_half(
            load<std::uint16_t>(std::array{bytes[i], bytes[i + count]}.data()));
      });
      break;
    default:  // oct88r8
      fill([&](std::size_t i) {
        return static_cast<float>(static_cast<std::uint8_t>(bytes[3 * (i % rows) + i / rows]));
      });
  }
  return values;
}

std::vector<LodFacts> rad_nodes(const RadChunk& chunk, bool has_own) {
  constexpr std::size_t kBytes =
      2 * kLodFootprints + 3 * sizeof(std::uint16_t) + sizeof(std::uint32_t);
  const std::size_t rows = chunk.count;
  const auto counts = rad_integers(chunk, kRadChildCount),
             starts = rad_integers(chunk, kRadChildStart);
  std::vector<LodFacts> nodes(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    nodes[i].child_count = static_cast<std::uint16_t>(counts[i]);
    nodes[i].first_child = starts[i];
  }
  if (!has_own) return nodes;
  if (chunk.own.empty()) fail("{}: quadsplat lod did not write it: it has no errors", chunk.source);
  Array<std::byte> bytes(kBytes * rows);
  inflate_all(chunk.own, bytes, chunk.source + ": quadsplat");
  const std::byte* const halves = &bytes[2 * kLodFootprints * rows];
  const std::byte* const parents = halves + 3 * rows * sizeof(std::uint16_t);
  for (std::size_t i = 0; i < rows; ++i) {
    LodFacts& node = nodes[i];
    for (std::size_t k = 0; k < kLodFootprints; ++k) {
      node.gains[k] = static_cast<std::uint8_t>(bytes[k * rows + i]);
      node.errors[k] = static_cast<std::uint8_t>(bytes[(kLodFootprints + k) * rows + i]);
    }
    const auto power = [&](std::size_t plane) {
      return std::exp2(float_of_any_half(load<std::uint16_t>(halves + 2 * (plane * rows + i))));
    };
    node.layers = power(0);
    node.opacities = power(1);
    node.radius = power(2);
    node.parent = load<std::uint32_t>(parents + 4 * i);
  }
  return nodes;
}

std::vector<std::uint32_t> rad_integers(const RadChunk& chunk, std::size_t kind) {
  Array<std::byte> room;
  const ByteSpan bytes = unpacked(chunk, kind, room);
  std::vector<std::uint32_t> integers(chunk.get(kind).rows);
  const bool is_short = chunk.get(kind).coding == RadCoding::u16;
  for (std::size_t i = 0; i < integers.size(); ++i)
    integers[i] =
        is_short ? load<std::uint16_t>(&bytes[2 * i]) : load<std::uint32_t>(&bytes[4 * i]);
  return integers;
}

}  // namespace qs
