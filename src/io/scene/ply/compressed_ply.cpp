// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/cloud/quantised.h"
#include "io/scene/ply/ply.h"
#include "io/scene/ply/ply_file.h"
#include "raster/kernel/constants.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/cloud_order.h"

namespace qs {
namespace {

constexpr std::uint64_t kChunkSize = 256;

struct ChunkRange {
  glm::dvec3 low{0}, high{1};
  // `t`: 0..1 within the bounds.
  glm::dvec3 at(const glm::dvec3& t) const { return low * (1.0 - t) + high * t; }
};

struct Chunk {
  ChunkRange position, scale, color;  // scale: logarithms
};

const PlyColumn& need(const PlyRows& rows, const std::string& name, const std::string& path) {
  const PlyColumn* const column = rows.find(name);
  if (column == nullptr) fail("{}: property {} is missing", path, name);
  return *column;
}

// The first `count` chunks; there are at least `count` rows.
Array<Chunk> read_chunks(const PlyRows& rows, std::uint64_t count, const std::string& path) {
  // Files have bounds of colours since 2024; in older files the bounds are 0 and 1.
  const std::size_t stored = rows.find("min_r") != nullptr ? kChunkProperties.size() : 12;
  std::vector<PlyColumn> columns;
  for (std::size_t i = 0; i < stored; ++i) columns.push_back(need(rows, kChunkProperties[i], path));
  Array<Chunk> chunks(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    Chunk& chunk = chunks[i];
    glm::dvec3* const bounds[] = {&chunk.position.low, &chunk.position.high, &chunk.scale.low,
                                  &chunk.scale.high,   &chunk.color.low,     &chunk.color.high};
    for (std::size_t k = 0; k < stored; ++k)
      (*bounds[k / 3])[static_cast<int>(k % 3)] = rows.value(i, columns[k]);
  }
  return chunks;
}

// Ascii numbers can have any value. Binary numbers of the usual types take the fast path, because a
// Gaussian has 49 of them.
std::uint32_t whole_number(const PlyRows& rows, std::uint64_t row, const PlyColumn& column,
                           std::uint32_t max, const std::string& path) {
  const std::byte* const at = rows.data + row * rows.row_bytes + column.offset;
  if (column.type == PlyType::u8) return static_cast<std::uint32_t>(*at);
  if (column.type == PlyType::u32 && max == 0xffffffff && !rows.swap_bytes)
    return load<std::uint32_t>(at);
  const double value = rows.value(row, column);
  if (!(value >= 0 && value <= max && value == std::floor(value)))
    fail("{}: row {}: {} is not a whole number from 0 to {}", path, row, column.name, max);
  return static_cast<std::uint32_t>(value);
}

// `bits` bits of `packed` from bit `shift` up, as 0..1.
double unit(std::uint32_t packed, int shift, int bits) {
  const std::uint32_t mask = (1u << bits) - 1;
  return ((packed >> shift) & mask) / static_cast<double>(mask);
}

glm::vec3 unpack_11_10_11(std::uint32_t packed, const ChunkRange& bounds) {
  return {bounds.at({unit(packed, 21, 11), unit(packed, 11, 10), unit(packed, 0, 11)})};
}

glm::quat unpack_rotation(std::uint32_t packed) {
  const auto component = [&](int shift) {
    return (unit(packed, shift, 10) - 0.5) * std::sqrt(2.0);
  };
  const auto q = restore_largest({component(20), component(10), component(0)}, packed >> 30);
  return make_quat(q[0], q[1], q[2], q[3]);
}

glm::vec3 unpack_color(std::uint32_t packed, const Chunk& chunk) {
  const glm::dvec3 color =
      chunk.color.at({unit(packed, 24, 8), unit(packed, 16, 8), unit(packed, 8, 8)});
  return {(color - 0.5) / kSh0};
}

// 0 and 255 mean -4 and 4, other bytes the middle of one of 256 steps between them.
float unpack_sh(std::uint32_t byte) {
  const double t = byte == 0 ? 0 : byte == 255 ? 1 : (byte + 0.5) / 256;
  return static_cast<float>((t - 0.5) * 8);
}

// The rows and columns of a file from which its Gaussians are unpacked.
struct PackedGaussians {
  std::string path;
  PlyRows rows, sh;
  PlyColumn position, rotation, scale, color;
  Array<Chunk> chunks;
  std::vector<PlyColumn> sh_columns;  // the SH bytes that are kept, channel by channel

  PackedGaussians(const std::string& name, PlyBody& body) : path(name) {
    const PlyRows chunk_rows = body.rows("chunk");
    rows = body.rows("vertex");
    position = need(rows, "packed_position", path);
    rotation = need(rows, "packed_rotation", path);
    scale = need(rows, "packed_scale", path);
    color = need(rows, "packed_color", path);
    const std::uint64_t needed = rows.count / kChunkSize + (rows.count % kChunkSize != 0);
    if (chunk_rows.count != needed)
      fail("{}: {} chunks for {} Gaussians, {} are needed", path, chunk_rows.count, rows.count,
           needed);
    chunks = read_chunks(chunk_rows, needed, path);
  }

  // Chooses the SH columns. Returns the degree that is kept.
  int choose_sh(PlyBody& body, bool has_sh, Scene& scene) {
    if (has_sh) sh = body.rows("sh");
    int stored = sh_rest_per_channel(sh.columns.size());
    if (stored < 0) {
      scene.warn("Only the base colour is used: {} values per row of element sh fit no degree.",
                 sh.columns.size());
      stored = 0;
    }
    if (has_sh && sh.count != rows.count)
      fail("{}: {} rows of element sh for {} Gaussians", path, sh.count, rows.count);
    const int degree = kept_sh_degree(stored, scene);
    for (int channel = 0; channel < 3; ++channel)
      for (int k = 0; k < sh_coefficient_count(degree) - 1; ++k)
        sh_columns.push_back(need(sh, fmt::format("f_rest_{}", channel * stored + k), path));
    return degree;
  }

  void unpack(std::size_t i, GaussianCloud& cloud) const {
    const auto packed = [&](const PlyColumn& column) {
      return whole_number(rows, i, column, 0xffffffff, path);
    };
    const Chunk& chunk = chunks[i / kChunkSize];
    const std::uint32_t packed_color = packed(color);
    cloud.positions[i] = unpack_11_10_11(packed(position), chunk.position);
    cloud.log_scales[i] = unpack_11_10_11(packed(scale), chunk.scale);
    cloud.rotations[i] = unpack_rotation(packed(rotation));
    cloud.opacity_logits[i] = logit_of_byte(static_cast<std::uint8_t>(packed_color));
    const std::size_t rest = sh_columns.size() / 3;
    glm::vec3* const coefficients = &cloud.sh[i * (rest + 1)];
    coefficients[0] = unpack_color(packed_color, chunk);
    for (std::size_t k = 0; k < rest; ++k) {
      for (int channel = 0; channel < 3; ++channel) {
        const PlyColumn& column = sh_columns[static_cast<std::size_t>(channel) * rest + k];
        coefficients[1 + k][channel] = unpack_sh(whole_number(sh, i, column, 255, path));
      }
    }
  }
};

constexpr float kMaxLogScale = 20;  // readers and writers agree on it; flat Gaussians get -20

std::string header_of(const GaussianCloud& cloud, std::size_t chunks, std::size_t rest) {
  constexpr std::array kPacked = {"packed_position", "packed_rotation", "packed_scale",
                                  "packed_color"};
  std::string header = kPlyStart + ply_element("chunk", chunks, "float", kChunkProperties) +
                       ply_element("vertex", cloud.size(), "uint", kPacked);
  if (rest > 0) header += ply_element("sh", cloud.size(), "uchar", ply_rest_names(3 * rest));
  if (cloud.antialiased) header += "comment SplatRenderMode: mip\n";
  return header + "end_header\n";
}

// The values of a Gaussian that are stored relative to its chunk.
struct Values {
  glm::vec3 position, log_scale, color;
};

struct Bounds {
  glm::vec3 low{std::numeric_limits<float>::infinity()};
  glm::vec3 high{-std::numeric_limits<float>::infinity()};

  void include(const glm::vec3& value) {
    low = glm::min(low, value);
    high = glm::max(high, value);
  }
  // 0..1 within the bounds.
  glm::dvec3 relative(const glm::vec3& value) const {
    const glm::dvec3 size = glm::dvec3(high) - glm::dvec3(low);
    glm::dvec3 t(0);
    for (int i = 0; i < 3; ++i)
      if (size[i] > 0)
        t[i] = (static_cast<double>(value[i]) - static_cast<double>(low[i])) / size[i];
    return t;
  }
};

struct ChunkBounds {
  Bounds position, log_scale, color;
};

Values values_of(const GaussianCloud& cloud, std::size_t i) {
  return {cloud.positions[i],
          glm::clamp(cloud.log_scales[i], glm::vec3(-kMaxLogScale), glm::vec3(kMaxLogScale)),
          glm::vec3(0.5 + kSh0 * glm::dvec3(*sh_of(cloud, i)))};
}

std::uint32_t pack_11_10_11(const glm::dvec3& t) {
  return round_to_integer(t.x * 2047, 2047) << 21 | round_to_integer(t.y * 1023, 1023) << 11 |
         round_to_integer(t.z * 2047, 2047);
}

std::uint32_t pack_rotation(const glm::quat& q) {
  const SmallestThree three = drop_largest({q.w, q.x, q.y, q.z});
  std::uint32_t packed = three.dropped;
  for (const double value : three.others)
    packed = packed << 10 | round_to_integer((value * std::sqrt(0.5) + 0.5) * 1023, 1023);
  return packed;
}

std::uint32_t pack_color(const glm::dvec3& t, float opacity_logit) {
  return round_to_integer(t.x * 255, 255) << 24 | round_to_integer(t.y * 255, 255) << 16 |
         round_to_integer(t.z * 255, 255) << 8 |
         round_to_integer(opacity_of_logit(opacity_logit) * 255, 255);
}

// 256 steps over -4..4; readers use the middle of a step.
std::uint8_t pack_sh(float value) {
  return static_cast<std::uint8_t>(
      std::clamp((static_cast<double>(value) / 8 + 0.5) * 256, 0.0, 255.0));
}

}  // namespace

bool recognises_compressed_ply(ByteSpan content, const std::filesystem::path&) {
  return is_ply(content) && ply_header_text(content).find(" packed_position") != std::string::npos;
}

void read_compressed_ply(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                         const ReadOptions& options, Scene& scene) {
  const PlyHeader header = parse_ply_header(content, path);
  PlyBody body(content, header, path, options.progress);
  PackedGaussians packed(path.string(), body);
  const int degree = packed.choose_sh(body, header.find("sh") != nullptr, scene);

  scene.format = "compressed.ply, " + describe(header.format);
  scene.cloud = make_cloud(packed.rows.count, degree);
  apply_ply_comments(header, scene);
  // PlyBody has reported up to here.
  const float start = packed.rows.decoded.empty() ? 0 : 0.5f;
  fill_cloud(scene, pool, options.progress, start, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) packed.unpack(i, scene.cloud);
  });
  for (std::string& warning : body.leftovers()) scene.warnings.push_back(std::move(warning));
}

void write_compressed_ply(const GaussianCloud& cloud, const std::filesystem::path& path,
                          ThreadPool&, const Progress& progress) {
  const auto order = morton_order(cloud);
  const std::size_t chunk_count = (cloud.size() + kChunkSize - 1) / kChunkSize;
  const auto rest = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree) - 1);
  // Find the bounds of the chunks.
  std::vector<ChunkBounds> chunks(chunk_count);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Values values = values_of(cloud, order[i]);
    ChunkBounds& chunk = chunks[i / kChunkSize];
    chunk.position.include(values.position);
    chunk.log_scale.include(values.log_scale);
    chunk.color.include(values.color);
  }
  progress.update(0.3f);

  // Pack the Gaussians relative to these bounds.
  std::vector<std::uint32_t> rows;
  std::vector<std::uint8_t> sh;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Values values = values_of(cloud, order[i]);
    const ChunkBounds& chunk = chunks[i / kChunkSize];
    rows.insert(rows.end(),
                {pack_11_10_11(chunk.position.relative(values.position)),
                 pack_rotation(cloud.rotations[order[i]]),
                 pack_11_10_11(chunk.log_scale.relative(values.log_scale)),
                 pack_color(chunk.color.relative(values.color), cloud.opacity_logits[order[i]])});
    const glm::vec3* const coefficients = sh_of(cloud, order[i]);
    for (int channel = 0; channel < 3; ++channel)
      for (std::size_t k = 1; k <= rest; ++k) sh.push_back(pack_sh(coefficients[k][channel]));
  }
  progress.update(0.6f);

  write_file(path, [&](std::ostream& file) {
    file << header_of(cloud, chunk_count, rest);
    std::vector<glm::vec3> bounds;
    for (const ChunkBounds& chunk : chunks)
      for (const Bounds* b : {&chunk.position, &chunk.log_scale, &chunk.color})
        bounds.insert(bounds.end(), {b->low, b->high});
    write_values(file, bounds);
    write_values(file, rows);
    write_values(file, sh);
  });
  progress.update(1);
}

}  // namespace qs
