// SPDX-License-Identifier: MIT
#include "app/session/shot.h"

#include <cctype>

#include <fmt/format.h>

#include "io/camera/cameras.h"
#include "version.h"

namespace qs {

std::string safe_file_name(std::string name) {
  for (char& c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80 && !std::isalnum(byte) && c != '-' && c != '.' && c != '_') c = '_';
  }
  return name;
}

std::filesystem::path with_word(const std::filesystem::path& path, const std::string& word) {
  std::filesystem::path result = path;
  result.replace_filename(fmt::format("{}_{}{}", path.stem().string(), safe_file_name(word),
                                      path.extension().string()));
  return result;
}

std::filesystem::path with_shot(const std::filesystem::path& path, const Shot& shot) {
  if (shot.number < 0) return path;
  const std::filesystem::path numbered = with_word(path, fmt::format("{:04}", shot.number));
  return shot.camera.name.empty() ? numbered : with_word(numbered, shot.camera.name);
}

ImageMetadata frame_metadata(const std::filesystem::path& scene, const Camera& camera,
                             CullMode mode, const RenderStats& stats) {
  return {{"Software", fmt::format("quadsplat {} ({})", kVersion, kCommit)},
          {"Scene", scene.filename().string()},
          {"Camera", format_camera(camera)},
          {"Mode", mode_name(mode)},
          {"TilePairs", fmt::format("{}", stats.tile_pairs)}};
}

}  // namespace qs
