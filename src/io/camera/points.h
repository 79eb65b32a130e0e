// SPDX-License-Identifier: MIT
//
// The points from structure from motion that a data set stores beside its cameras: COLMAP's
// points3D.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace qs {

struct ScenePoint {
  glm::dvec3 position{0};  ///< world, finite
  glm::vec3 color{0};      ///< RGB, 0..1
};

/// The points3D.bin or points3D.txt of a data set's folder, of its `sparse` or `sparse/0`.
std::optional<std::filesystem::path> find_points_file(const std::filesystem::path& data);

/// All points of a points3D file in file order. Throws Error(input) naming file and record.
std::vector<ScenePoint> read_points(const std::filesystem::path& file);

/// The formats. They are for read_points().
std::vector<ScenePoint> read_colmap_points_binary(const std::filesystem::path& file);
std::vector<ScenePoint> read_colmap_points_text(const std::filesystem::path& file);

}  // namespace qs
