// SPDX-License-Identifier: MIT
//
// Finds files of a trained model, cameras and cfg_args: next to the scene file or in one of the
// three folders above it (MODEL/point_cloud/iteration_N/point_cloud.ply).
#include <system_error>

#include "io/bytes/json_text.h"
#include "io/camera/camera_formats.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

std::optional<std::filesystem::path> find_beside(const std::filesystem::path& scene_file,
                                                 const char* name) {
  std::error_code error;
  std::filesystem::path folder =
      std::filesystem::absolute(scene_file, error).lexically_normal().parent_path();
  for (int level = 0; level <= 3; ++level) {
    if (std::filesystem::is_regular_file(folder / name, error)) return folder / name;
    if (folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::filesystem::path> find_cameras_file(const std::filesystem::path& scene_file) {
  for (const CameraFormat& format : camera_formats()) {
    if (auto found = find_beside(scene_file, format.place)) return found;
  }
  return std::nullopt;
}

bool model_wants_white_background(const std::filesystem::path& scene_file) {
  constexpr std::size_t kMaxBytes = 1 << 20;
  const auto path = find_beside(scene_file, "cfg_args");
  // A Python Namespace(...) in one line.
  return path &&
         read_text_file(*path, kMaxBytes).find("white_background=True") != std::string::npos;
}

}  // namespace qs
