// SPDX-License-Identifier: MIT
#include "app/viewer/preferences.h"

#include <cstdlib>
#include <system_error>

#include <fmt/format.h>

#include "io/bytes/file_guard.h"
#include "io/bytes/json_text.h"
#include "io/bytes/replace_file.h"

namespace qs {

std::filesystem::path preferences_file() {
  const char* config = std::getenv("XDG_CONFIG_HOME");
  if (config != nullptr && *config != '\0')
    return std::filesystem::path(config) / "quadsplat/viewer.json";
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0') return {};
  return std::filesystem::path(home) / ".config/quadsplat/viewer.json";
}

std::string read_preferences(const std::filesystem::path& file, Viewer& viewer,
                             glm::ivec2& window_size) {
  constexpr std::size_t kMaxBytes = std::size_t{4} << 20;
  std::error_code error;
  if (file.empty() || !std::filesystem::exists(file, error)) return "";
  try {
    const std::string text = read_text_file(file, kMaxBytes);
    note_own(file);  // the window replaces it
    parse_preferences(text, viewer, window_size);
    return "";
  } catch (const std::exception& why) {
    return fmt::format("{}: the settings cannot be read and are ignored: {}", file.string(),
                       why.what());
  }
}

void write_preferences(const std::filesystem::path& file, const Viewer& viewer,
                       glm::ivec2 window_size) {
  if (file.empty()) return;
  make_folder(file.parent_path());
  write_text(file, format_preferences(viewer, window_size));
}

}  // namespace qs
