// SPDX-License-Identifier: MIT
//
// Photographs of a folder and below, found by the names of cameras. Names are compared without
// endings; when a camera's name begins with folders that the photograph's path lacks, they are left
// out one by one ("images/left/7" finds left/7.jpg, then 7.jpg).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include <glm/vec3.hpp>

#include "raster/base/parallel.h"
#include "raster/scene/image.h"

namespace qs {

class Photographs {
 public:
  /// Lists the folder; reads no picture. Throws Error(input) when it is none.
  explicit Photographs(const std::filesystem::path& folder);

  std::optional<std::filesystem::path> find(const std::string& camera_name) const;

 private:
  std::map<std::string, std::filesystem::path> files_;  // by path in the folder, without ending
};

/// RGB, gray repeated, transparency laid over the background; area-averaged to 1 / `divisor` of its
/// size, rounded. Throws Error.
Image read_photograph(const std::filesystem::path& path, glm::vec3 background, int divisor,
                      ThreadPool& pool);

}  // namespace qs
