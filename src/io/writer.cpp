// SPDX-License-Identifier: MIT
#include "io/writer.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>

#include "io/ply_writer.h"
#include "raster/scene/fail.h"

namespace qs {
namespace {

constexpr std::array kWriters = {
    WriterRow{"ply", ".ply", "INRIA's layout, lossless", write_ply},
};

}  // namespace

std::span<const WriterRow> writers() { return kWriters; }

void write_scene(const GaussianCloud& cloud, const std::filesystem::path& path,
                 const Progress& progress) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::string known;
  for (const WriterRow& row : kWriters) {
    if (extension == row.extension) return row.write(cloud, path, progress);
    known += fmt::format(" {}", row.extension);
  }
  fail(ErrorKind::usage, "{}: cannot write '{}' files; writable are:{}", path.string(), extension,
       known);
}

}  // namespace qs
