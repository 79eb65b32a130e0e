// SPDX-License-Identifier: MIT
//
// The measures of a scene as a file, SCENE.measures.json (docs/formats.md#measures).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "io/edits/scene_file.h"
#include "raster/select/measures.h"

namespace qs {

struct MeasuresFile {
  EditedScene scene;
  Measures measures;
  std::vector<std::string> warnings = {};  ///< sentences about members that are not known
};

inline constexpr std::size_t kMaxMeasureBytes = std::size_t{16} << 20;
inline constexpr std::size_t kMaxMeasuredPoints = 10'000;

/// Reads measures. `origin`: of the cloud; places in the file count from 0, points from there.
/// Throws Error(input) naming file, point and member.
MeasuresFile read_measures(const std::filesystem::path& path, const glm::dvec3& origin);
/// The same of a text, which `source` names in messages.
MeasuresFile parse_measures(std::string_view text, const std::string& source,
                            const glm::dvec3& origin);

/// The text of a file that read_measures() reads back, without empty lines.
std::string format_measures(const MeasuresFile& file, const glm::dvec3& origin);

}  // namespace qs
