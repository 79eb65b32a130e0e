// SPDX-License-Identifier: MIT
//
// Names of the files that commands write.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "app/viewer/state/viewer.h"

namespace qs {

/// FOLDER/STEM_0001ENDING with the first number whose file does not exist yet.
inline std::filesystem::path free_name(const std::filesystem::path& folder, const std::string& stem,
                                       const std::string& ending) {
  std::filesystem::path path;
  std::error_code error;
  for (int n = 1; path.empty() || std::filesystem::exists(path, error); ++n)
    path = folder / fmt::format("{}_{:04}{}", stem, n, ending);
  return path;
}

/// "camera3" at a camera of the data set, else "view".
inline std::string camera_name(const Viewer& viewer) {
  return viewer.dataset_camera >= 0 ? fmt::format("camera{}", viewer.dataset_camera) : "view";
}

}  // namespace qs
