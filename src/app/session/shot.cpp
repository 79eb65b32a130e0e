// SPDX-License-Identifier: MIT
#include "app/session/shot.h"

#include <cctype>

#include <fmt/format.h>

#include "app/session/alterations.h"
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

ImageMetadata altered_metadata(const Session& session) {
  const std::string altered = alterations_of(session).text;
  return altered.empty() ? ImageMetadata() : ImageMetadata{{"Altered", altered}};
}

ImageMetadata frame_metadata(const Session& session, const Camera& camera, CullMode mode,
                             const RenderStats& stats) {
  ImageMetadata metadata = {{"Software", fmt::format("quadsplat {} ({})", kVersion, kCommit)},
                            {"Scene", session.scene->path.filename().string()},
                            {"Camera", format_camera(camera)},
                            {"Mode", mode_name(mode)},
                            {"TilePairs", fmt::format("{}", stats.tile_pairs)}};
  metadata.merge(altered_metadata(session));
  return metadata;
}

}  // namespace qs
