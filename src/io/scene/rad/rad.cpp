// SPDX-License-Identifier: MIT
#include "io/scene/rad/rad.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <glm/gtc/packing.hpp>

#include "base/text.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/file_source.h"
#include "io/bytes/inflate.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/cloud/linear_values.h"
#include "io/cloud/lod_tree.h"
#include "io/cloud/quantised.h"
#include "raster/kernel/constants.h"

namespace qs {
namespace {

using json = nlohmann::json;

constexpr std::string_view kFileMagic = "RAD0", kChunkMagic = "RADC";
constexpr std::uint64_t kMaxNodes = std::uint64_t{1} << 32;  // child_start has 32 bits

enum class Coding {
  f32,
  f16,
  f32_lebytes,  // all lowest bytes come first
  f16_lebytes,
  r8,        // a byte within min..max
  r8_delta,  // the difference to the byte before
  s8,        // a signed byte, 127 is max
  s8_delta,
  ln_f16,   // a logarithm
  ln_0r8,   // 0, or a logarithm within min..max
  oct88r8,  // two bytes of an octahedral axis and one of an angle, side by side
  u16,
  u32
};
struct CodingRow {
  std::string_view name;
  std::uint64_t bytes;  // per value
  bool has_min, has_max;
};
constexpr std::array kCodings = {CodingRow{"f32", 4, false, false},
                                 CodingRow{"f16", 2, false, false},
                                 CodingRow{"f32_lebytes", 4, false, false},
                                 CodingRow{"f16_lebytes", 2, false, false},
                                 CodingRow{"r8", 1, true, true},
                                 CodingRow{"r8_delta", 1, true, true},
                                 CodingRow{"s8", 1, false, true},
                                 CodingRow{"s8_delta", 1, false, true},
                                 CodingRow{"ln_f16", 2, false, false},
                                 CodingRow{"ln_0r8", 1, true, true},
                                 CodingRow{"oct88r8", 1, false, false},
                                 CodingRow{"u16", 2, false, false},
                                 CodingRow{"u32", 4, false, false}};

enum PropertyKind {
  kCenter,
  kAlpha,
  kRgb,
  kScales,
  kOrientation,
  kSh,  // of degrees 1, 2 and 3
  kCodes = kSh + 3,
  kLabel = kCodes + 3,
  kChildCount,
  kChildStart,
  kPropertyKinds
};
struct PropertyRow {
  std::string_view name;
  std::uint64_t values;  // per node
  std::string_view codings;
};
constexpr std::string_view kShCodings = "f32 f16 s8 s8_delta r8 r8_delta";
constexpr std::array<PropertyRow, kPropertyKinds> kProperties = {{
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

struct Property {
  Coding coding = Coding::f32;
  bool deflated = false;
  double min = 0, max = 0;
  std::uint64_t rows = 0;
  ByteSpan bytes;
};

struct Chunk {
  std::string source;       // for messages
  Array<std::byte> loaded;  // of a file of its own
  std::uint64_t base = 0, count = 0;
  std::array<std::optional<Property>, kPropertyKinds> properties;
  std::uint64_t ignored_bytes = 0;
  std::vector<std::string> unknown;  // names of properties

  bool has(int kind) const { return properties[static_cast<std::size_t>(kind)].has_value(); }
  const Property& get(int kind) const { return *properties[static_cast<std::size_t>(kind)]; }
};

// A magic word, a length, JSON of that length, and zeros up to a multiple of 8.
json read_description(ByteCursor& cursor, std::string_view magic, const std::string& source) {
  if (text_of(cursor.take(magic.size(), "the magic word")) != magic)
    fail("{}: does not begin with '{}'", source, magic);
  const auto bytes = cursor.read<std::uint32_t>("the header");
  json description = parse_json(text_of(cursor.take(bytes, "the description")), source);
  if (!description.is_object()) fail("{}: its description is not an object", source);
  cursor.take((8 - bytes % 8) % 8, "the end of the description");
  if (const auto version = JsonEntry{description, source}.whole("version"); version != 1)
    fail("{}: version {}, only 1 exists", source, version);
  return description;
}

const json& list_in(const JsonEntry& entry, const char* key) {
  const json& list = entry.get(key);
  if (!list.is_array()) fail("{}: {} is not a list", entry.where, key);
  for (const json& each : list)
    if (!each.is_object()) fail("{}: {} has something else than objects", entry.where, key);
  return list;
}

Property parse_property(const JsonEntry& entry, const PropertyRow& row, ByteSpan bytes,
                        std::uint64_t rows) {
  Property property{.rows = rows, .bytes = bytes};
  const std::string& name = entry.text("encoding");
  const auto* const coding = std::ranges::find(kCodings, name, &CodingRow::name);
  const auto allowed = separated(row.codings, ' ');
  if (coding == kCodings.end() || std::ranges::count(allowed, name) == 0)
    fail("{}: the encoding '{}' cannot be read; there are: {}", entry.where, printable(name),
         row.codings);
  property.coding = static_cast<Coding>(coding - kCodings.begin());
  if (coding->has_min) property.min = entry.number("min");
  if (coding->has_max) property.max = entry.number("max");
  property.deflated = entry.has("compression");
  if (property.deflated && entry.text("compression") != "gz")
    fail("{}: the compression '{}' is not known", entry.where,
         printable(entry.text("compression")));
  const std::uint64_t needed = row.values * coding->bytes * rows;  // far below 2^64
  if (property.deflated ? !fits(needed, 1, bytes.size() * kMaxInflation) : needed != bytes.size())
    fail("{}: {} bytes for {} values, which take {}", entry.where, bytes.size(), row.values * rows,
         needed);
  return property;
}

// `code_count`: rows of the tables of SH, if the file states them.
Chunk parse_chunk(ByteSpan content, const std::string& source,
                  std::optional<std::uint64_t> code_count) {
  Chunk chunk;
  chunk.source = source;
  ByteCursor cursor(content, source);
  const json description = read_description(cursor, kChunkMagic, source);
  const JsonEntry entry{description, source};
  chunk.base = entry.whole("base");
  chunk.count = entry.whole("count");
  const auto payload_bytes = cursor.read<std::uint64_t>("the payload's size");
  const ByteSpan payload = cursor.take(payload_bytes, "the payload");
  std::uint64_t end = 0;  // of the properties so far
  for (const json& each : list_in(entry, "properties")) {
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
    const auto kind = row - kProperties.begin();
    auto& property = chunk.properties[static_cast<std::size_t>(kind)];
    if (property) fail("{}: is there twice", stored.where);
    const bool is_table = kind >= kCodes && kind < kLabel;
    property =
        parse_property(stored, *row, part, is_table && code_count ? *code_count : chunk.count);
  }
  chunk.ignored_bytes =
      payload.size() - std::min<std::uint64_t>(end, payload.size()) + cursor.left();
  for (int kind = 0; kind < kSh; ++kind)
    if (!chunk.has(kind))
      fail("{}: it has no {}", source, kProperties[static_cast<std::size_t>(kind)].name);
  return chunk;
}

ByteSpan unpacked(const Chunk& chunk, int kind, Array<std::byte>& room) {
  const Property& property = chunk.get(kind);
  if (!property.deflated) return property.bytes;
  const PropertyRow& row = kProperties[static_cast<std::size_t>(kind)];
  const std::uint64_t needed =
      row.values * kCodings[static_cast<std::size_t>(property.coding)].bytes * property.rows;
  const std::string source = fmt::format("{}: {}", chunk.source, row.name);
  room.resize(needed + 1);  // one more than allowed detects excess
  const std::size_t bytes = Inflater(property.bytes, source, DeflateForm::deflate).read(room);
  if (bytes != needed)
    fail("{}: {} {} bytes unpacked, {} are needed", source, bytes > needed ? "more than" : "only",
         std::min<std::uint64_t>(bytes, needed), needed);
  return ByteSpan(room).first(needed);
}

float value_of_byte(const Property& property, std::uint8_t byte) {
  const double range = property.max - property.min;
  switch (property.coding) {
    case Coding::s8:
    case Coding::s8_delta:
      return static_cast<float>(static_cast<std::int8_t>(byte) / 127.0 * property.max);
    case Coding::ln_0r8:
      return byte == 0 ? -std::numeric_limits<float>::infinity()
                       : static_cast<float>(property.min + (byte - 1) * range / 254);
    case Coding::r8:
    case Coding::r8_delta:
      return static_cast<float>(property.min + byte * range / 255);
    default:
      return byte;
  }
}

// Value k of row i is at k * rows + i.
std::vector<float> values_of(const Chunk& chunk, int kind) {
  Array<std::byte> room;
  const ByteSpan bytes = unpacked(chunk, kind, room);
  const Property& property = chunk.get(kind);
  const std::size_t rows = property.rows;
  const std::size_t count = kProperties[static_cast<std::size_t>(kind)].values * rows;
  std::vector<float> values(count);
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes[i]); };
  std::uint8_t last = 0;
  for (std::size_t i = 0; i < count; ++i) {
    switch (property.coding) {
      case Coding::f32:
        values[i] = load<float>(&bytes[4 * i]);
        break;
      case Coding::f16:
      case Coding::ln_f16:
        values[i] = glm::unpackHalf1x16(load<std::uint16_t>(&bytes[2 * i]));
        break;
      case Coding::f32_lebytes: {
        const std::array four = {bytes[i], bytes[i + count], bytes[i + 2 * count],
                                 bytes[i + 3 * count]};
        values[i] = load<float>(four.data());
        break;
      }
      case Coding::f16_lebytes:
        values[i] = glm::unpackHalf1x16(static_cast<std::uint16_t>(byte(i) | byte(i + count) << 8));
        break;
      case Coding::r8_delta:
      case Coding::s8_delta:
        if (i % rows == 0) last = 0;
        last = static_cast<std::uint8_t>(last + byte(i));
        values[i] = value_of_byte(property, last);
        break;
      case Coding::oct88r8:
        values[i] = byte(3 * (i % rows) + i / rows);
        break;
      default:
        values[i] = value_of_byte(property, byte(i));
        break;
    }
  }
  return values;
}

std::vector<std::uint32_t> integers_of(const Chunk& chunk, int kind) {
  Array<std::byte> room;
  const ByteSpan bytes = unpacked(chunk, kind, room);
  const Property& property = chunk.get(kind);
  std::vector<std::uint32_t> integers(property.rows);
  for (std::size_t i = 0; i < integers.size(); ++i)
    integers[i] = property.coding == Coding::u16 ? load<std::uint16_t>(&bytes[2 * i])
                                                 : load<std::uint32_t>(&bytes[4 * i]);
  return integers;
}

// An octahedral axis, bytes for -1..1, and an angle, a byte for 0..pi.
glm::quat rotation_of_octahedron(float u, float v, float angle) {
  double x = u / 127.5 - 1, y = v / 127.5 - 1;
  const double z = 1 - std::abs(x) - std::abs(y);
  const double fold = std::max(-z, 0.0);
  x += x >= 0 ? -fold : fold;
  y += y >= 0 ? -fold : fold;
  const double half = angle / 255.0 * std::numbers::pi / 2;
  const double factor = std::sin(half) / std::sqrt(x * x + y * y + z * z);
  return make_quat(std::cos(half), x * factor, y * factor, z * factor);
}

class RadFile {
 public:
  RadFile(ByteSpan content, const std::filesystem::path& path, Scene& scene)
      : path_(path.string()) {
    if (text_of(content).starts_with(kChunkMagic)) {
      chunks_.push_back(parse_chunk(content, path_, {}));
      chunks_[0].base = 0;
      is_part_ = true;
    } else {
      read_chunks(content, path, scene);
    }
    for (const Chunk& chunk : chunks_) count_ += chunk.count;
    if (count_ == 0) fail("{}: holds no Gaussians", path_);
    const auto has_children = [](const Chunk& chunk) {
      return chunk.has(kChildCount) || chunk.has(kChildStart);
    };
    has_tree_ = has_tree_ || std::ranges::any_of(chunks_, has_children);
    if (has_tree_) read_tree();
    for (std::size_t band = 0; band < 3; ++band) {
      if (!chunks_[0].has(kCodes + static_cast<int>(band))) continue;
      codes_[band] = values_of(chunks_[0], kCodes + static_cast<int>(band));
      code_rows_ = chunks_[0].get(kCodes + static_cast<int>(band)).rows;
    }
  }

  std::size_t leaf_count() const { return has_tree_ ? tree_.leaves.size() : count_; }
  std::size_t chunk_count() const { return chunks_.size(); }

  int sh_degree() const {
    int degree = 0;
    for (int band = 1; band <= 3; ++band)
      for (const Chunk& chunk : chunks_)
        if (chunk.has(kSh + band - 1) || chunk.has(kCodes + band - 1)) degree = band;
    return degree;
  }

  // Fills the leaves of one chunk. May be called from several threads for different chunks.
  void fill(std::size_t number, GaussianCloud& cloud, LinearValues& linear) {
    const Chunk& chunk = chunks_[number];
    const auto leaves_before = [&](std::uint64_t node) -> std::size_t {
      if (!has_tree_) return node;
      const auto at = std::ranges::lower_bound(tree_.leaves, node);
      return static_cast<std::size_t>(at - tree_.leaves.begin());
    };
    const std::size_t begin = leaves_before(chunk.base);
    const std::size_t end = leaves_before(chunk.base + chunk.count);
    // Calls use(k, row) for leaf k of the cloud and its row of the chunk.
    const auto for_leaves = [&](const auto& use) {
      for (std::size_t k = begin; k < end; ++k)
        use(k, static_cast<std::size_t>((has_tree_ ? tree_.leaves[k] : k) - chunk.base));
    };
    const std::size_t rows = chunk.count;
    const auto fill_from = [&](int kind, const auto& use) {
      const std::vector<float> values = values_of(chunk, kind);
      for_leaves([&](std::size_t k, std::size_t row) {
        use(k, [&](std::size_t value) { return values[value * rows + row]; });
      });
    };
    fill_from(kCenter, [&](std::size_t k, const auto& v) {
      cloud.positions[k] = {v(0), v(1), v(2)};
    });
    fill_from(kAlpha, [&](std::size_t k, const auto& v) {
      cloud.opacity_logits[k] = linear.logit(static_cast<double>(v(0)));
    });
    const bool are_logarithms = chunk.get(kScales).coding != Coding::f32;
    fill_from(kScales, [&](std::size_t k, const auto& v) {
      const glm::vec3 scale(v(0), v(1), v(2));
      cloud.log_scales[k] = are_logarithms ? scale : linear.log_scale(scale);
    });
    const bool is_octahedral = chunk.get(kOrientation).coding == Coding::oct88r8;
    fill_from(kOrientation, [&](std::size_t k, const auto& v) {
      if (is_octahedral) {
        cloud.rotations[k] = rotation_of_octahedron(v(0), v(1), v(2));
      } else {
        const auto q = restore_largest({v(0), v(1), v(2)}, 3);
        cloud.rotations[k] = make_quat(q[3], q[0], q[1], q[2]);
      }
    });
    fill_from(kRgb, [&](std::size_t k, const auto& v) {
      glm::vec3* const sh = sh_of(cloud, k);
      std::fill_n(sh, sh_count(cloud), glm::vec3(0));
      for (int c = 0; c < 3; ++c)
        sh[0][c] =
            static_cast<float>((static_cast<double>(v(static_cast<std::size_t>(c))) - 0.5) / kSh0);
    });
    for (std::size_t band = 1; band <= 3; ++band) {
      if (!chunk.has(kSh + static_cast<int>(band) - 1)) continue;
      fill_from(kSh + static_cast<int>(band) - 1,
                [&](std::size_t k, const auto& v) { put_band(band, sh_of(cloud, k), v); });
    }
    if (!chunk.has(kLabel) || code_rows_ == 0) return;
    const std::vector<std::uint32_t> labels = integers_of(chunk, kLabel);
    for_leaves([&](std::size_t k, std::size_t row) {
      const std::size_t label = labels[row];
      if (label >= code_rows_) {
        ++unlabelled_;
        return;
      }
      for (std::size_t band = 1; band <= 3; ++band) {
        const std::vector<float>& codes = codes_[band - 1];
        if (codes.empty()) continue;
        put_band(band, sh_of(cloud, k),
                 [&](std::size_t value) { return codes[value * code_rows_ + label]; });
      }
    });
  }

  void describe(Scene& scene) const {
    scene.format = is_part_ ? "rad, one chunk" : has_tree_ ? "rad" : "rad, without levels";
    if (has_tree_ && !is_part_)
      scene.levels = {tree_.levels, count_, tree_.leaves.size(), count_ - tree_.leaves.size()};
    if (is_part_)
      scene.warn("One chunk of a .rad file: {} leaves of its {} nodes were read.", leaf_count(),
                 count_);
    std::uint64_t ignored = ignored_bytes_;
    std::set<std::string> unknown;
    for (const Chunk& chunk : chunks_) {
      ignored += chunk.ignored_bytes;
      unknown.insert(chunk.unknown.begin(), chunk.unknown.end());
    }
    for (const std::string& name : unknown)
      scene.warn("The property '{}' is not known and was ignored.", name);
    if (ignored > 0)
      scene.warn("{} bytes after the properties of its chunks were ignored.", ignored);
    if (unlabelled_ > 0)
      scene.warn(
          "{} Gaussians have only their base colour: their spherical harmonics are not in the "
          "table.",
          unlabelled_.load());
  }

 private:
  // The values of a band, channel fastest.
  template <class Value>
  static void put_band(std::size_t band, glm::vec3* sh, const Value& value) {
    for (std::size_t i = 0; i < 3 * (2 * band + 1); ++i)
      sh[band * band + i / 3][static_cast<int>(i % 3)] = value(i);
  }

  void read_chunks(ByteSpan content, const std::filesystem::path& path, Scene& scene) {
    ByteCursor cursor(content, path_);
    const json description = read_description(cursor, kFileMagic, path_);
    const JsonEntry entry{description, path_};
    if (entry.has("type") && entry.text("type") != "gsplat")
      fail("{}: the type '{}' is not known", path_, printable(entry.text("type")));
    const std::uint64_t count = entry.whole("count");
    const std::uint64_t size = entry.has("chunkSize") ? entry.whole("chunkSize") : count;
    const json& list = list_in(entry, "chunks");
    if (count == 0) fail("{}: holds no Gaussians", path_);
    if (count > kMaxNodes) fail("{}: {} nodes, more than 2^32", path_, count);
    if (size == 0 || list.size() != (count + size - 1) / size)
      fail("{}: {} nodes in {} chunks of {}", path_, count, list.size(), size);
    if (entry.has("lodTree")) has_tree_ = entry.get("lodTree") == true;
    std::optional<std::uint64_t> codes;
    if (entry.has("shCodeCount")) codes = entry.whole("shCodeCount");
    const ByteSpan body = cursor.take(cursor.left(), "the chunks");
    const auto files = files_beside(path);
    std::uint64_t used = 0;
    for (std::uint64_t i = 0; i < list.size(); ++i) {
      const std::string source = fmt::format("{}: chunk {}", path_, i);
      const JsonEntry range{list[i], source};
      const std::uint64_t offset = range.whole("offset"), bytes = range.whole("bytes");
      Array<std::byte> loaded;
      ByteSpan part;
      if (range.has("filename")) {
        loaded = files->read(range.text("filename"), bytes);
        scene.file_bytes += loaded.size();
        part = loaded;
      } else {
        if (offset > body.size() || bytes > body.size() - offset)
          fail("{}: cut off: {} bytes at offset {} of {}", source, bytes, offset, body.size());
        part = body.subspan(offset, bytes);
        used = std::max(used, offset + bytes);
      }
      Chunk chunk = parse_chunk(part, source, codes);
      const std::uint64_t base = i * size, expected = std::min(size, count - base);
      if (chunk.base != base || chunk.count != expected)
        fail("{}: holds {} nodes from node {} on, but must hold {} from node {} on", source,
             chunk.count, chunk.base, expected, base);
      chunk.loaded = std::move(loaded);  // its place in memory stays
      chunks_.push_back(std::move(chunk));
    }
    ignored_bytes_ = body.size() - used;
  }

  void read_tree() {
    std::vector<std::uint32_t> starts;
    std::vector<std::uint16_t> counts;
    for (const Chunk& chunk : chunks_) {
      for (const int kind : {kChildCount, kChildStart})
        if (!chunk.has(kind))
          fail("{}: it has no {}, but the file has a tree", chunk.source,
               kProperties[static_cast<std::size_t>(kind)].name);
      for (const std::uint32_t each : integers_of(chunk, kChildCount))
        counts.push_back(static_cast<std::uint16_t>(each));
      const auto part = integers_of(chunk, kChildStart);
      starts.insert(starts.end(), part.begin(), part.end());
    }
    if (is_part_) {  // its tree lies in other chunks too
      for (std::size_t i = 0; i < counts.size(); ++i)
        if (counts[i] == 0) tree_.leaves.push_back(static_cast<std::uint32_t>(i));
      if (tree_.leaves.empty()) fail("{}: this chunk of a .rad file has no leaves", path_);
    } else {
      tree_ = read_lod_tree(
          counts.size(),
          [&](std::size_t i) {
            return LodChildren{starts[i], counts[i]};
          },
          path_);
    }
  }

  std::string path_;
  std::vector<Chunk> chunks_;
  bool is_part_ = false, has_tree_ = false;
  std::uint64_t count_ = 0, ignored_bytes_ = 0;
  LodTree tree_;
  std::array<std::vector<float>, 3> codes_;  // of SH, by band
  std::size_t code_rows_ = 0;
  std::atomic<std::size_t> unlabelled_ = 0;
};

}  // namespace

bool recognises_rad(ByteSpan content, const std::filesystem::path&) {
  const std::string_view text = text_of(content);
  return text.starts_with(kFileMagic) || text.starts_with(kChunkMagic);
}

void read_rad(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
              const ReadOptions& options, Scene& scene) {
  constexpr float kDecoded = 0.9f;  // share of the progress
  RadFile file(content, path, scene);
  scene.cloud = make_cloud(file.leaf_count(), file.sh_degree());
  LinearValues linear;
  pool.for_chunks(file.chunk_count(), 1, [&](std::size_t chunk, std::size_t, int worker) {
    if (worker == 0)
      options.progress.update(kDecoded * static_cast<float>(chunk) /
                              static_cast<float>(file.chunk_count()));
    file.fill(chunk, scene.cloud, linear);
  });
  fill_cloud(scene, pool, options.progress, kDecoded, [](std::size_t, std::size_t) {});
  linear.warn(scene);
  file.describe(scene);
}

}  // namespace qs
