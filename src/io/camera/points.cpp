// SPDX-License-Identifier: MIT
#include "io/camera/points.h"

#include <system_error>

namespace qs {

std::optional<std::filesystem::path> find_points_file(const std::filesystem::path& data) {
  std::error_code error;
  for (const char* folder : {"sparse/0", "sparse", "0", "."}) {
    for (const char* name : {"points3D.bin", "points3D.txt"}) {
      const auto file = (data / folder / name).lexically_normal();
      if (std::filesystem::is_regular_file(file, error)) return file;
    }
  }
  return std::nullopt;
}

std::vector<ScenePoint> read_points(const std::filesystem::path& file) {
  return file.extension() == ".txt" ? read_colmap_points_text(file)
                                    : read_colmap_points_binary(file);
}

}  // namespace qs
