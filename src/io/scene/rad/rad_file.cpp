// SPDX-License-Identifier: MIT
#include "io/scene/rad/rad_file.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "base/text.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/quantised.h"
#include "raster/kernel/constants.h"

namespace qs {
namespace {

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

}  // namespace

void RadHeader::require_inside(std::size_t i, std::uint64_t bytes,
                               const std::string& source) const {
  const Range& range = chunks[i];
  if (range.offset > bytes || range.bytes > bytes - range.offset)
    fail("{}: chunk {}: cut off: {} bytes at offset {} of {}", source, i, range.bytes, range.offset,
         bytes);
}

RadChunk RadHeader::chunk(std::size_t i, ByteSpan content, const std::string& source) const {
  RadChunk chunk = parse_rad_chunk(content, fmt::format("{}: chunk {}", source, i), codes);
  const std::uint64_t base = i * chunk_nodes, expected = std::min(chunk_nodes, count - base);
  if (chunk.base != base || chunk.count != expected)
    fail("{}: holds {} nodes from node {} on, but must hold {} from node {} on", chunk.source,
         chunk.count, chunk.base, expected, base);
  if (has_originals && chunk.original.empty())
    fail("{}: has no original values, unlike its file", chunk.source);
  return chunk;
}

RadHeader read_rad_header(ByteCursor& cursor, const std::string& source) {
  const nlohmann::json description = read_rad_description(cursor, kRadFileMagic, source);
  const JsonEntry entry{description, source};
  if (entry.has("type") && entry.text("type") != "gsplat")
    fail("{}: the type '{}' is not known", source, printable(entry.text("type")));
  RadHeader header;
  header.count = entry.whole("count");
  header.chunk_nodes = entry.has("chunkSize") ? entry.whole("chunkSize") : header.count;
  const nlohmann::json& list = rad_list(entry, "chunks");
  if (header.count == 0) return header;
  if (header.chunk_nodes == 0 || header.count >> 32 != 0 ||
      list.size() != (header.count + header.chunk_nodes - 1) / header.chunk_nodes)
    fail("{}: {} nodes in {} chunks of {}", source, header.count, list.size(), header.chunk_nodes);
  header.has_tree = entry.has("lodTree") && entry.get("lodTree") == true;
  if (entry.has("quadsplat")) {
    const JsonEntry own{entry.get("quadsplat"), source + ": quadsplat"};
    const double footprint = own.number("footprint");
    if (footprint > 0 && footprint < 1e30) header.footprint = static_cast<float>(footprint);
    const auto is_set = [&](const char* key) { return own.has(key) && own.get(key) == true; };
    header.antialiased = is_set("antialiased");
    header.has_originals = is_set("original");
    if (own.has("origin")) header.origin = own.vector<3>("origin");
    if (glm::length(header.origin) > 1e9) fail("{}: origin is too far away", own.where);
  }
  if (entry.has("shCodeCount")) header.codes = entry.whole("shCodeCount");
  for (std::size_t i = 0; i < list.size(); ++i) {
    const JsonEntry range{list[i], fmt::format("{}: chunk {}", source, i)};
    header.chunks.push_back({range.whole("offset"), range.whole("bytes"), {}});
    if (range.has("filename")) header.chunks.back().file = range.text("filename");
  }
  return header;
}

RadCodes::RadCodes(const RadChunk& first) {
  for (std::size_t band = 0; band < bands.size(); ++band) {
    const auto& table = first.properties[kRadCodes + band];
    if (!table) continue;
    bands[band] = rad_values(first, kRadCodes + band);
    rows = table->rows;
  }
}

std::size_t fill_gaussians(const RadChunk& chunk, const RadCodes& codes,
                           std::span<const std::uint32_t> rows,
                           std::span<const std::uint32_t> places, GaussianCloud& cloud,
                           LinearValues& linear) {
  // Calls use(k, v) for Gaussian k and its values v(0), v(1) ... of a property.
  const auto fill_from = [&](std::size_t kind, const auto& use) {
    const Array<float> values = rad_values(chunk, kind);
    for (std::size_t i = 0; i < rows.size(); ++i)
      use(places[i], [&](std::size_t value) { return values[value * chunk.count + rows[i]]; });
  };
  fill_from(kRadCenter, [&](std::size_t k, const auto& v) {
    cloud.positions[k] = {v(0), v(1), v(2)};
  });
  fill_from(kRadAlpha, [&](std::size_t k, const auto& v) {
    cloud.opacity_logits[k] = linear.logit(static_cast<double>(v(0)));
  });
  const bool are_logarithms = chunk.get(kRadScales).coding != RadCoding::f32;
  fill_from(kRadScales, [&](std::size_t k, const auto& v) {
    const glm::vec3 scale(v(0), v(1), v(2));
    cloud.log_scales[k] = are_logarithms ? scale : linear.log_scale(scale);
  });
  const bool is_octahedral = chunk.get(kRadOrientation).coding == RadCoding::oct88r8;
  fill_from(kRadOrientation, [&](std::size_t k, const auto& v) {
    const auto q = restore_largest({v(0), v(1), v(2)}, 3);
    cloud.rotations[k] = is_octahedral ? rotation_of_octahedron(v(0), v(1), v(2))
                                       : make_quat(q[3], q[0], q[1], q[2]);
  });
  fill_from(kRadRgb, [&](std::size_t k, const auto& v) {
    sh_of(cloud, k)[0] = (glm::dvec3(v(0), v(1), v(2)) - 0.5) / static_cast<double>(kSh0);
  });
  // The SH of a degree of Gaussian k, the channel fastest.
  const auto band_of = [sh = &cloud.sh.data()->x, stride = 3 * sh_count(cloud)](std::size_t degree,
                                                                                std::size_t k) {
    return sh + k * stride + 3 * degree * degree;
  };
  for (std::size_t degree = 1; degree <= static_cast<std::size_t>(cloud.sh_degree); ++degree) {
    const std::size_t kind = kRadSh + degree - 1;
    // Planes that lie a power of two apart push each other out of the cache: a few rows at a time.
    const auto fill_band = [&](const auto& values) {
      constexpr std::size_t kBlock = 64;
      std::array<float*, kBlock> to;
      for (std::size_t begin = 0; begin < rows.size(); begin += kBlock) {
        const auto from = rows.subspan(begin, std::min(kBlock, rows.size() - begin));
        for (std::size_t i = 0; i < from.size(); ++i) to[i] = band_of(degree, places[begin + i]);
        for (std::size_t v = 0; v < 3 * (2 * degree + 1); ++v)
          for (std::size_t i = 0; i < from.size(); ++i)
            to[i][v] = values[v * chunk.count + from[i]];
      }
    };
    if (!chunk.properties[kind])
      for (const std::uint32_t k : places)
        std::fill_n(band_of(degree, k), 3 * (2 * degree + 1), 0.0f);
    else if (const auto bytes = rad_bytes(chunk, kind))
      fill_band(*bytes);
    else
      fill_band(rad_values(chunk, kind));
  }
  std::size_t unlabelled = 0;
  if (!chunk.properties[kRadLabel]) return unlabelled;
  const std::vector<std::uint32_t> labels = rad_integers(chunk, kRadLabel);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t label = labels[rows[i]];
    unlabelled += label >= codes.rows ? 1 : 0;
    for (std::size_t degree = 1; label < codes.rows && degree <= 3; ++degree)
      if (const Array<float>& band = codes.bands[degree - 1]; !band.empty())
        for (std::size_t v = 0; v < 3 * (2 * degree + 1); ++v)
          band_of(degree, places[i])[v] = band[v * codes.rows + label];
  }
  return unlabelled;
}

}  // namespace qs
