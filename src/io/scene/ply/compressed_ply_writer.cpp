// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "io/bytes/byte_cursor.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/quantised.h"
#include "io/scene/ply/ply.h"
#include "raster/kernel/constants.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/cloud_order.h"

namespace qs {
namespace {

constexpr std::size_t kChunkGaussians = 256;
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

void write_compressed_ply(const GaussianCloud& cloud, const std::filesystem::path& path,
                          ThreadPool&, const Progress& progress) {
  const auto order = morton_order(cloud);
  const std::size_t chunk_count = (cloud.size() + kChunkGaussians - 1) / kChunkGaussians;
  const auto rest = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree) - 1);
  // Find the bounds of the chunks.
  std::vector<ChunkBounds> chunks(chunk_count);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Values values = values_of(cloud, order[i]);
    ChunkBounds& chunk = chunks[i / kChunkGaussians];
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
    const ChunkBounds& chunk = chunks[i / kChunkGaussians];
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
