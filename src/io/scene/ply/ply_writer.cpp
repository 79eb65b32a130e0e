// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <fstream>
#include <ostream>
#include <string>
#include <vector>

#include "base/fail.h"
#include "base/parallel.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/scene/ply/ply.h"
#include "raster/scene/place.h"

namespace qs {
namespace {

// Values of a row besides f_rest.
constexpr std::size_t kFixedValues = 17;

std::string header_of(const PlyContent& content, bool doubles, const std::string& comment) {
  const auto rest = static_cast<std::size_t>(sh_coefficient_count(content.sh_degree) - 1);
  std::vector<std::string> names = {"nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"};
  for (std::string& name : ply_rest_names(3 * rest)) names.push_back(std::move(name));
  for (const char* name :
       {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    names.emplace_back(name);
  // INRIA's viewer expects the element in the third line, so comments come after it.
  std::string header = kPlyStart + fmt::format("element vertex {}\n", content.count);
  header += ply_properties(doubles ? "double" : "float", std::array{"x", "y", "z"});
  header += ply_properties("float", names) + comment;
  if (content.antialiased) header += "comment SplatRenderMode: mip\n";
  return header + "end_header\n";
}

void fill_row(const GaussianCloud& cloud, std::size_t i, std::size_t rest, float* row) {
  const auto put = [&row](const glm::vec3& v) {
    row[0] = v.x;
    row[1] = v.y;
    row[2] = v.z;
    row += 3;
  };
  const glm::vec3* const sh = sh_of(cloud, i);
  put(cloud.positions[i]);
  put(glm::vec3(0));  // the normal
  put(sh[0]);
  for (int channel = 0; channel < 3; ++channel)
    for (std::size_t k = 1; k <= rest; ++k) *row++ = sh[k][channel];
  *row++ = cloud.opacity_logits[i];
  put(cloud.log_scales[i]);
  const glm::quat& q = cloud.rotations[i];
  for (const float value : {q.w, q.x, q.y, q.z}) *row++ = value;
}

// The rows with world positions as doubles, which floats would round.
std::string with_doubles(const GaussianCloud& cloud, std::size_t first, std::span<const float> rows,
                         std::size_t values) {
  std::string bytes;
  for (std::size_t row = 0; row * values < rows.size(); ++row) {
    const glm::dvec3 world = cloud.origin + glm::dvec3(cloud.positions[first + row]);
    put_values(bytes, world.x, world.y, world.z);
    const std::span rest = rows.subspan(row * values + 3, values - 3);
    bytes.append(reinterpret_cast<const char*>(rest.data()), rest.size_bytes());
  }
  return bytes;
}

// `doubles`: positions are doubles in the world.
void write_rows(const GaussianCloud& cloud, bool doubles, ThreadPool& pool,
                const Progress& progress, std::ostream& file) {
  constexpr std::size_t kRowsPerWrite = 1 << 15;  // 8 MB with SH degree 3
  constexpr std::size_t kRowsPerChunk = 1 << 10;
  const auto rest = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree) - 1);
  const std::size_t values = kFixedValues + 3 * rest;
  Array<float> buffer(std::min(kRowsPerWrite, cloud.size()) * values);
  for (std::size_t first = 0; first < cloud.size() && file; first += kRowsPerWrite) {
    progress.update(static_cast<float>(first) / static_cast<float>(cloud.size()));
    const std::size_t rows = std::min(kRowsPerWrite, cloud.size() - first);
    pool.for_each(rows, kRowsPerChunk,
                  [&](std::size_t i) { fill_row(cloud, first + i, rest, &buffer[i * values]); });
    const auto written = std::span(buffer).first(rows * values);
    doubles ? void(file << with_doubles(cloud, first, written, values))
            : write_values(file, written);
  }
  progress.update(1);
}

// `comment`: lines of the header, or empty.
void write_whole(const GaussianCloud& cloud, bool doubles, const std::string& comment,
                 const std::filesystem::path& path, ThreadPool& pool, const Progress& progress) {
  write_file(path, [&](std::ostream& file) {
    file << header_of({cloud.size(), cloud.sh_degree, cloud.antialiased}, doubles, comment);
    write_rows(cloud, doubles, pool, progress, file);
  });
}

}  // namespace

std::vector<std::string> ply_rest_names(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) names.push_back(fmt::format("f_rest_{}", i));
  return names;
}

void write_ply(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool& pool,
               const Progress& progress) {
  write_whole(cloud, cloud.origin != glm::dvec3(0), "", path, pool, progress);
}

void write_trained_ply(const GaussianCloud& cloud, const std::filesystem::path& path,
                       ThreadPool& pool) {
  std::string comment = kTrainedComment;
  if (cloud.origin != glm::dvec3(0))
    comment += fmt::format("comment {}{}\n", kOriginComment, format_origin(cloud.origin));
  write_whole(cloud, false, comment, path, pool, {});
}

void write_ply_parts(const PlyContent& content, const std::filesystem::path& path, ThreadPool& pool,
                     const std::function<GaussianCloud()>& next_part) {
  write_file(path, [&](std::ostream& file) {
    file << header_of(content, false, "");
    for (std::size_t written = 0; written < content.count && file;) {
      const GaussianCloud part = next_part();
      written += part.size();
      assert(part.sh_degree == content.sh_degree && !part.empty() && written <= content.count);
      write_rows(part, false, pool, {}, file);
    }
  });
}

bool is_trained_ply(const std::filesystem::path& path) {
  std::string header(std::size_t{1} << 13, '\0');  // longer than any header of this file
  std::ifstream file(path, std::ios::binary);
  file.read(header.data(), static_cast<std::streamsize>(header.size()));
  header.resize(static_cast<std::size_t>(file.gcount()));
  header.resize(std::min(header.size(), header.find("end_header\n")));
  return header.starts_with("ply\n") && header.find(kTrainedComment) != std::string::npos;
}

}  // namespace qs
