// SPDX-License-Identifier: MIT
//
// The edits of a scene as a file, SCENE.edits.json (docs/formats.md#edits).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "io/edits/scene_file.h"
#include "raster/select/edit_step.h"

namespace qs {

struct EditsFile {
  EditedScene scene;
  std::vector<EditStep> steps;
  std::vector<std::string> warnings = {};  ///< sentences about members that are not known
};

inline constexpr std::size_t kMaxEditBytes = std::size_t{64} << 20;
inline constexpr std::size_t kMaxEditSteps = 10'000, kMaxCorners = 4096;

/// Reads edits. `origin`: of the cloud; places in the file count from 0, steps from there. Throws
/// Error(input) naming file, step and member.
EditsFile read_edits(const std::filesystem::path& path, const glm::dvec3& origin);
/// The same of a text, which `source` names in messages.
EditsFile parse_edits(std::string_view text, const std::string& source, const glm::dvec3& origin);

/// The text of a file that read_edits() reads back to the same steps.
std::string format_edits(const EditsFile& edits, const glm::dvec3& origin);

}  // namespace qs
