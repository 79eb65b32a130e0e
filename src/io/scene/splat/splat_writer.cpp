// SPDX-License-Identifier: MIT
#include "io/scene/splat/splat_writer.h"

#include <array>
#include <cmath>
#include <cstring>
#include <ostream>

#include "io/bytes/byte_writer.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/quantised.h"
#include "raster/kernel/constants.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/cloud_order.h"

namespace qs {
namespace {

using Row = std::array<std::uint8_t, 32>;

Row row_of(const GaussianCloud& cloud, std::size_t i) {
  Row row;
  const glm::vec3 scale = glm::exp(cloud.log_scales[i]);
  std::memcpy(row.data(), &cloud.positions[i], 12);
  std::memcpy(row.data() + 12, &scale, 12);
  const glm::vec3& dc = *sh_of(cloud, i);
  for (std::size_t c = 0; c < 3; ++c) {
    const double color = 0.5 + kSh0 * static_cast<double>(dc[static_cast<int>(c)]);
    row[24 + c] = static_cast<std::uint8_t>(round_to_integer(color * 255, 255));
  }
  row[27] = static_cast<std::uint8_t>(
      round_to_integer(opacity_of_logit(cloud.opacity_logits[i]) * 255, 255));
  const glm::quat& q = cloud.rotations[i];
  std::size_t at = 28;
  for (const float component : {q.w, q.x, q.y, q.z}) {
    row[at++] = static_cast<std::uint8_t>(round_to_integer(component * 128.0 + 128, 255));
  }
  return row;
}

}  // namespace

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
