// SPDX-License-Identifier: MIT
#include "io/scene/rad/rad_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <ostream>
#include <utility>

#include <libdeflate.h>
#include <nlohmann/json.hpp>

#include "io/bytes/byte_cursor.h"
#include "io/bytes/inflate.h"
#include "io/bytes/json_text.h"
#include "io/scene/rad/rad_chunk.h"
#include "io/scene/rad/rad_original.h"
#include "raster/kernel/constants.h"
#include "raster/kernel/half.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

constexpr int kDeflateLevel = 1;

void pad(std::string& bytes) { bytes.resize((bytes.size() + 7) / 8 * 8); }

// -65504 stands for a value of 0.
std::uint16_t half_log2(float value) { return nearest_half(std::log2(value)); }

std::string described(std::string_view magic, const std::string& json) {
  std::string bytes(magic);
  put_values(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += json;
  pad(bytes);
  return bytes;
}

// x, y, z of a rotation whose w is the largest component and positive, so that it follows from
// halves of the others. Half a turn about an axis of the ellipsoid changes nothing and exchanges
// components.
std::array<float, 3> stored_rotation(const glm::quat& q) {
  const std::array<std::array<float, 4>, 4> turned = {{{q.w, q.x, q.y, q.z},
                                                       {-q.x, q.w, q.z, -q.y},
                                                       {-q.y, -q.z, q.w, q.x},
                                                       {-q.z, q.y, -q.x, q.w}}};
  const auto& best = *std::ranges::max_element(
      turned, {}, [](const std::array<float, 4>& r) { return std::abs(r[0]); });
  const float sign = best[0] < 0 ? -1 : 1;
  return {sign * best[1], sign * best[2], sign * best[3]};
}

class ChunkEncoder {
 public:
  ChunkEncoder(const RadNodes& chunk, const RadPlan& plan) : chunk_(chunk), plan_(plan) {}

  std::string encode(std::uint64_t base) {
    const auto& nodes = chunk_.nodes;
    // All lowest bytes come first.
    add("center", "f32_lebytes", planes<std::uint8_t>(12, [&](std::size_t row, std::size_t k) {
          const auto axis = static_cast<int>(k % 3);
          return std::bit_cast<std::uint32_t>(nodes[row].center[axis]) >> 8 * (k / 3);
        }));
    add("alpha", "f16", planes<std::uint16_t>(1, [&](std::size_t row, std::size_t) {
          return nearest_half(nodes[row].alpha);
        }));
    add_sh("rgb", "f16", 0);
    add("scales", "ln_f16", planes<std::uint16_t>(3, [&](std::size_t row, std::size_t k) {
          return nearest_half(std::log(nodes[row].scales[static_cast<int>(k)]));
        }));
    std::vector<std::array<float, 3>> rotations;
    for (const LodNode& node : nodes) rotations.push_back(stored_rotation(node.rotation));
    add("orientation", "f16", planes<std::uint16_t>(3, [&](std::size_t row, std::size_t k) {
          return nearest_half(rotations[row][k]);
        }));
    constexpr std::array kNames = {"sh1", "sh2", "sh3"};
    for (std::size_t degree = 1; degree <= static_cast<std::size_t>(plan_.sh_degree); ++degree)
      add_sh(kNames[degree - 1], "s8", degree);
    add("child_count", "u16", planes<std::uint16_t>(1, [&](std::size_t row, std::size_t) {
          return nodes[row].child_count;
        }));
    add("child_start", "u32", planes<std::uint32_t>(1, [&](std::size_t row, std::size_t) {
          return nodes[row].first_child;
        }));
    ordered_json own = add_block(own_block());
    if (plan_.original) own["original"] = add_block(original_block());
    const ordered_json json = {{"version", 1},
                               {"base", base},
                               {"count", chunk_.nodes.size()},
                               {"payloadBytes", payload_.size()},
                               {"maxSh", plan_.sh_degree},
                               {"lodTree", true},
                               {"properties", properties_},
                               {"quadsplat", own}};
    std::string bytes = described(kRadChunkMagic, json_line(json));
    put_values(bytes, std::uint64_t{payload_.size()});
    return bytes + payload_;
  }

 private:
  // A plane of each value(row, k), k < values. A few rows at a time stay in the cache.
  template <class T, class Value>
  std::string planes(std::size_t values, const Value& value) const {
    constexpr std::size_t kBlock = 64;
    const std::size_t rows = chunk_.nodes.size();
    std::string bytes(values * rows * sizeof(T), '\0');
    for (std::size_t begin = 0; begin < rows; begin += kBlock)
      for (std::size_t k = 0; k < values; ++k)
        for (std::size_t row = begin; row < std::min(begin + kBlock, rows); ++row) {
          const auto each = static_cast<T>(value(row, k));
          std::memcpy(&bytes[(k * rows + row) * sizeof each], &each, sizeof each);
        }
    return bytes;
  }

  void add(const char* name, const char* encoding, const std::string& plain,
           ordered_json more = ordered_json::object()) {
    const std::string packed = deflated(plain, kDeflateLevel);
    ordered_json property = {{"offset", payload_.size()},
                             {"bytes", packed.size()},
                             {"property", name},
                             {"encoding", encoding},
                             {"compression", "gz"}};
    property.update(more);
    properties_.push_back(std::move(property));
    payload_ += packed;
    pad(payload_);
  }

  ordered_json add_block(const std::string& plain) {
    const std::string block = deflated(plain, kDeflateLevel);
    const ordered_json described = {{"offset", payload_.size()},
                                    {"bytes", block.size()},
                                    {"crc32", libdeflate_crc32(0, block.data(), block.size())}};
    payload_ += block;
    pad(payload_);
    return described;
  }

  // SH of a degree; degree 0 as colours.
  void add_sh(const char* name, const char* encoding, std::size_t degree) {
    const std::size_t first = 3 * degree * degree, values = 3 * (2 * degree + 1),
                      stride = chunk_.sh.size() / chunk_.nodes.size();
    const auto half = [&](std::size_t row, std::size_t k) {
      return chunk_.sh[row * stride + first + k];
    };
    if (degree == 0)
      return add(
          name, encoding, planes<std::uint16_t>(values, [&](std::size_t row, std::size_t k) {
            return nearest_half(0.5f + static_cast<float>(kSh0) * float_of_half(half(row, k)));
          }));
    int most = 0;  // bits of halves without their sign have the order of the values
    for (std::size_t row = 0; row < chunk_.nodes.size(); ++row)
      for (std::size_t k = 0; k < values; ++k) most = std::max(most, half(row, k) & 0x7fff);
    const float max = std::max(float_of_half(static_cast<std::uint16_t>(most)), 1e-6f);
    add(name, encoding,
        planes<std::int8_t>(values,
                            [&](std::size_t row, std::size_t k) {
                              const float scaled = float_of_half(half(row, k)) / max * 127;
                              return static_cast<int>(scaled + (scaled < 0 ? -0.5f : 0.5f));
                            }),
        {{"min", -max}, {"max", max}});
  }

  std::string own_block() const {
    const auto& nodes = chunk_.nodes;
    const auto steps = [&](LodSteps LodFacts::*list) {
      return planes<std::uint8_t>(
          kLodFootprints, [&](std::size_t row, std::size_t k) { return (nodes[row].*list)[k]; });
    };
    constexpr std::array kSizes = {&LodNode::layers, &LodNode::opacities, &LodNode::radius};
    return steps(&LodNode::gains) + steps(&LodNode::errors) +
           planes<std::uint16_t>(
               kSizes.size(),
               [&](std::size_t row, std::size_t k) { return half_log2(nodes[row].*kSizes[k]); }) +
           planes<std::uint32_t>(1,
                                 [&](std::size_t row, std::size_t) { return nodes[row].parent; });
  }

  std::string original_block() const {
    const std::size_t words = original_words(plan_.sh_degree);
    std::string bytes;
    for (std::size_t k = 0; k < words; ++k)
      for (int shift = 0; shift < 32; shift += 8)
        for (std::size_t i = k; i < chunk_.original.size(); i += words)
          bytes += static_cast<char>(chunk_.original[i] >> shift);
    return bytes;
  }

  const RadNodes& chunk_;
  const RadPlan& plan_;
  std::string payload_;
  ordered_json properties_ = ordered_json::array();
};

}  // namespace

void RadNodes::append(const RadNodes& from, std::size_t begin, std::size_t end) {
  if (begin == end) return;
  const auto add = [](auto& to, const auto& list, std::size_t first, std::size_t last) {
    to.insert(to.end(), list.begin() + static_cast<std::ptrdiff_t>(first),
              list.begin() + static_cast<std::ptrdiff_t>(last));
  };
  const std::size_t values = from.sh.size() / from.nodes.size();
  add(nodes, from.nodes, begin, end);
  add(sh, from.sh, begin * values, end * values);
  if (from.original.empty()) return;
  const auto leaves = [&](std::size_t count) {
    return static_cast<std::size_t>(
        std::ranges::count(std::span(from.nodes).first(count), 0, &LodNode::child_count));
  };
  const std::size_t words = from.original.size() / leaves(from.nodes.size());
  add(original, from.original, leaves(begin) * words, leaves(end) * words);
}

RadWriter::RadWriter(std::ostream& stream, const RadPlan& plan, ThreadPool& pool)
    : stream_(stream), plan_(plan), pool_(pool) {
  header_bytes_ = header(false).size();
  stream_ << std::string(header_bytes_, '\0');
}

void RadWriter::write(std::span<const RadNodes> chunks) {
  std::vector<std::string> encoded(chunks.size());
  pool_.for_each(chunks.size(), 1, [&](std::size_t i) {
    encoded[i] = ChunkEncoder(chunks[i], plan_).encode(next_ + i * kChunk);
  });
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    next_ += chunks[i].nodes.size();
    chunk_bytes_.push_back(encoded[i].size());
    stream_ << encoded[i];
  }
}

void RadWriter::finish() {
  stream_.seekp(0);
  stream_ << header(true);
}

// The largest header if the sizes of the chunks are not known.
std::string RadWriter::header(bool is_final) const {
  constexpr std::uint64_t kMostChunkBytes = 99'999'999, kMostBytes = 99'999'999'999'999;
  ordered_json chunks = ordered_json::array();
  std::uint64_t offset = 0;
  for (std::uint64_t i = 0; i < (plan_.nodes + kChunk - 1) / kChunk; ++i) {
    const std::uint64_t bytes = is_final ? chunk_bytes_[i] : kMostChunkBytes;
    chunks.push_back({{"offset", is_final ? offset : kMostBytes}, {"bytes", bytes}});
    offset += bytes;
  }
  ordered_json json = {
      {"version", 1},
      {"type", "gsplat"},
      {"count", plan_.nodes},
      {"maxSh", plan_.sh_degree},
      {"lodTree", true},
      {"chunkSize", kChunk},
      {"allChunkBytes", is_final ? offset : kMostBytes},
      {"chunks", std::move(chunks)},
      {"splatEncoding",
       {{"rgbMin", 0.0},
        {"rgbMax", 1.0},
        {"lnScaleMin", -12.0},
        {"lnScaleMax", 9.0},
        {"sh1Max", 1.0},
        {"sh2Max", 1.0},
        {"sh3Max", 1.0},
        {"lodOpacity", false}}},
      {"quadsplat", {{"footprint", plan_.footprint}, {"antialiased", plan_.antialiased}}}};
  if (plan_.original) json["quadsplat"]["original"] = true;
  if (const glm::dvec3& o = plan_.origin; o != glm::dvec3(0))
    json["quadsplat"]["origin"] = {o.x, o.y, o.z};
  std::string text = json_line(json);
  if (is_final) text.resize(header_bytes_ - 8, ' ');  // JSON may end with spaces
  return described("RAD0", text);
}

}  // namespace qs
