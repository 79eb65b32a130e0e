// SPDX-License-Identifier: MIT
//
// A view that a command renders, and the names and the metadata of its files.
#pragma once

#include <filesystem>
#include <string>

#include "app/session/session.h"
#include "io/picture/image_file.h"

namespace qs {

struct Shot {
  Camera camera;
  int number = -1;     ///< position in the cameras file or on the path, -1 if it has none
  std::string origin;  ///< shown to users: "camera 3 (IMG_0004)", "path 0003", "framing"
};

/// OUT.png -> OUT_0003_NAME.png for a numbered shot, OUT.png for others.
std::filesystem::path with_shot(const std::filesystem::path& path, const Shot& shot);

/// Replaces ASCII characters other than letters, digits, '-', '.', '_' by '_'.
std::string safe_file_name(std::string name);

/// OUT.png -> OUT_WORD.png, with a safe_file_name().
std::filesystem::path with_word(const std::filesystem::path& path, const std::string& word);

/// "Altered": the session's alterations, if there are any.
ImageMetadata altered_metadata(const Session& session);

/// Metadata of every picture of the session's scene: enough to render it again, and
/// altered_metadata().
ImageMetadata frame_metadata(const Session& session, const Camera& camera, CullMode mode,
                             const RenderStats& stats);

}  // namespace qs
