// SPDX-License-Identifier: MIT
#include "io/scene/splat/splat.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <ostream>

#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/cloud/quantised.h"
#include "raster/kernel/constants.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/cloud_order.h"

namespace qs {

namespace {

constexpr std::size_t kRowBytes = 32;
constexpr std::size_t kScale = 12, kColor = 24, kOpacity = 27, kRotation = 28;

glm::vec3 vector(const std::byte* at) {
  return {load<float>(at), load<float>(at + 4), load<float>(at + 8)};
}

int component(const std::byte* row, std::size_t i) {
  return static_cast<int>(row[kRotation + i]) - 128;
}

int rotation_square(const std::byte* row) {
  int square = 0;
  for (std::size_t i = 0; i < 4; ++i) square += component(row, i) * component(row, i);
  return square;
}

// Other data rarely looks like a unit quaternion after finite floats.
bool is_plausible(const std::byte* row) {
  constexpr float kMaxPosition = 1e9f, kMaxScale = 1e6f;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(vector(row)[axis]) < kMaxPosition)) return false;
    if (!(vector(row + kScale)[axis] >= 0 && vector(row + kScale)[axis] < kMaxScale)) return false;
  }
  const double length = std::sqrt(rotation_square(row)) / 128;
  return length > 0.95 && length < 1.05;
}

using Row = std::array<std::uint8_t, kRowBytes>;

Row row_of(const GaussianCloud& cloud, std::size_t i) {
  Row row;
  const glm::vec3 scale = glm::exp(cloud.log_scales[i]);
  std::memcpy(row.data(), &cloud.positions[i], 12);
  std::memcpy(row.data() + kScale, &scale, 12);
  const glm::vec3& dc = *sh_of(cloud, i);
  for (std::size_t c = 0; c < 3; ++c) {
    const double color = 0.5 + kSh0 * static_cast<double>(dc[static_cast<int>(c)]);
    row[kColor + c] = static_cast<std::uint8_t>(round_to_integer(color * 255, 255));
  }
  row[kOpacity] = static_cast<std::uint8_t>(
      round_to_integer(opacity_of_logit(cloud.opacity_logits[i]) * 255, 255));
  const glm::quat& q = cloud.rotations[i];
  std::size_t at = kRotation;
  for (const float component : {q.w, q.x, q.y, q.z})
    row[at++] = static_cast<std::uint8_t>(round_to_integer(component * 128.0 + 128, 255));
  return row;
}

}  // namespace

bool recognises_splat(ByteSpan content, const std::filesystem::path&) {
  constexpr std::size_t kLookedAt = 64;
  const std::size_t rows = std::min(content.size() / kRowBytes, kLookedAt);
  if (rows == 0 || content.size() % kRowBytes != 0) return false;
  for (std::size_t i = 0; i < rows; ++i)
    if (!is_plausible(content.data() + i * kRowBytes)) return false;
  return true;
}

void read_splat(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                const ReadOptions& options, Scene& scene) {
  const std::size_t count = content.size() / kRowBytes, rest = content.size() % kRowBytes;
  if (count == 0)
    fail("{}: cut off: {} bytes, one Gaussian needs {}", path.string(), content.size(), kRowBytes);
  if (rest != 0)
    scene.warn("The last {} bytes are no whole row of {} and were ignored.", rest, kRowBytes);
  scene.format = "splat";
  scene.cloud = make_cloud(count, 0);
  GaussianCloud& cloud = scene.cloud;
  std::atomic<std::size_t> unrotated = 0;

  const auto fill = [&](std::size_t i) {
    const std::byte* const row = content.data() + i * kRowBytes;
    cloud.positions[i] = vector(row);
    cloud.log_scales[i] = glm::log(vector(row + kScale));
    for (int c = 0; c < 3; ++c) {
      const auto byte = static_cast<double>(row[kColor + static_cast<std::size_t>(c)]);
      cloud.sh[i][c] = static_cast<float>((byte / 255 - 0.5) / kSh0);
    }
    cloud.opacity_logits[i] = logit_of_byte(static_cast<std::uint8_t>(row[kOpacity]));
    if (rotation_square(row) == 0) {
      cloud.rotations[i] = make_quat(1, 0, 0, 0);
      ++unrotated;
    } else {
      cloud.rotations[i] =
          make_quat(component(row, 0), component(row, 1), component(row, 2), component(row, 3));
    }
  };
  fill_cloud(scene, pool, options.progress, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) fill(i);
  });
  if (unrotated > 0) warn_of_missing_rotations(scene, unrotated);
}

void write_splat(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool&,
                 const Progress& progress) {
  constexpr std::size_t kRowsPerWrite = 1 << 15;
  const auto order = largest_first(cloud);
  write_file(path, [&](std::ostream& file) {
    std::vector<Row> rows;
    for (std::size_t i = 0; i < order.size(); ++i) {
      rows.push_back(row_of(cloud, order[i]));
      if (rows.size() < kRowsPerWrite && i + 1 < order.size()) continue;
      write_values(file, rows);
      rows.clear();
      progress.update(static_cast<float>(i + 1) / static_cast<float>(order.size()));
    }
  });
}

}  // namespace qs
