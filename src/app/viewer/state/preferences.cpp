// SPDX-License-Identifier: MIT
#include "app/viewer/state/preferences.h"

#include <cstdlib>
#include <system_error>

#include "app/report/stats_file.h"
#include "app/report/write_report.h"
#include "io/bytes/json_text.h"
#include "raster/base/error.h"

namespace qs {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{4} << 20;

}  // namespace

std::filesystem::path preferences_file() {
  const char* config = std::getenv("XDG_CONFIG_HOME");
  if (config != nullptr && *config != '\0')
    return std::filesystem::path(config) / "quadsplat/viewer.json";
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0') return {};
  return std::filesystem::path(home) / ".config/quadsplat/viewer.json";
}

Preferences read_preferences(const std::filesystem::path& file, std::string& problem) {
  std::error_code error;
  if (file.empty() || !std::filesystem::exists(file, error)) return {};
  try {
    return parse_preferences(read_text_file(file, kMaxBytes), file.string(), problem);
  } catch (const Error& why) {
    problem = why.what();
    return {};
  }
}

void write_preferences(const std::filesystem::path& file, const Preferences& preferences) {
  if (file.empty()) return;
  make_folder(file.parent_path());
  write_stats(file, format_preferences(preferences));
}

}  // namespace qs
