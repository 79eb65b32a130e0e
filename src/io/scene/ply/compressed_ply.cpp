// SPDX-License-Identifier: MIT

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/cloud/quantised.h"
#include "io/scene/ply/ply.h"
#include "io/scene/ply/ply_file.h"
#include "raster/kernel/constants.h"

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

}  // namespace qs
