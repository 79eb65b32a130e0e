// SPDX-License-Identifier: MIT
//
// Photographs in a folder and its subfolders, found by the names of cameras. Names are compared
// without endings. Leading folders of a camera's name are dropped one by one until a photograph
// matches: "images/left/7" finds left/7.jpg, else 7.jpg.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/parallel.h"
#include "io/camera/lens.h"
#include "raster/scene/camera.h"
#include "raster/scene/image.h"

namespace qs {

class Photographs {
 public:
  /// Lists the folder without reading pictures. Throws Error(input) if it is not a folder.
  /// `counted` receives the number of pictures so far.
  explicit Photographs(const std::filesystem::path& folder,
                       const std::function<void(std::size_t count)>& counted = {});

  std::optional<std::filesystem::path> find(const std::string& camera_name) const;

  /// Paths in the folder without endings, in alphabetical order.
  std::vector<std::string> names() const;

 private:
  std::map<std::string, std::filesystem::path> files_;  // key: path in the folder without ending
};

/// "3 views without a photograph are left out".
std::string skipped_sentence(std::size_t views);

/// Reads a photograph as RGB, blended over the background where it is transparent, undistorted if
/// `taken` has a lens, and area-averaged to 1 / `divisor` of its size, rounded. Throws Error.
Image read_photograph(const std::filesystem::path& path, glm::vec3 background, int divisor,
                      ThreadPool& pool, const LensCamera& taken = {});

/// The photograph area-averaged to 1 / `divisor` of its size, rounded.
Image divided(const Image& photograph, int divisor, ThreadPool& pool);

/// A photograph may be smaller or larger than its camera's image, but must have its aspect ratio,
/// up to rounded sizes. Otherwise it was cropped or rotated: throws Error(input) naming `path`.
void require_same_shape(const Image& photograph, const std::filesystem::path& path,
                        const Camera& camera);

/// The photograph without the distortion of its lens, in the same size: every pixel is interpolated
/// from the four pixels around the point at which the lens shows its direction.
Image undistorted(const Image& photograph, const LensCamera& camera, ThreadPool& pool);

}  // namespace qs
