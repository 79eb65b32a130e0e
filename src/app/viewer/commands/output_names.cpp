// SPDX-License-Identifier: MIT
#include "app/viewer/commands/output_names.h"

#include <system_error>

#include <fmt/format.h>

namespace qs {

std::filesystem::path free_name(const std::filesystem::path& folder, const std::string& stem,
                                const std::string& ending) {
  for (int n = 1;; ++n) {
    std::filesystem::path path = folder / fmt::format("{}_{:04}{}", stem, n, ending);
    std::error_code error;
    if (!std::filesystem::exists(path, error)) return path;
  }
}

std::string camera_name(const Viewer& viewer) {
  return viewer.dataset_camera >= 0 ? fmt::format("camera{}", viewer.dataset_camera) : "view";
}

}  // namespace qs
