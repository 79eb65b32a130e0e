// SPDX-License-Identifier: MIT
//
// The facts of a scene that the viewer keeps, and the files beside it.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>

#include "app/viewer/state/viewer.h"
#include "io/scene/reader.h"

namespace qs {

/// Facts of a scene, with the cameras of `cameras_file` (found beside the scene when empty) and the
/// photographs in the folder `images` beside them. `up`: as in FrameOptions. Throws Error if
/// `cameras_file` cannot be read.
ViewedScene view_facts(const Scene& scene, const std::optional<std::filesystem::path>& cameras_file,
                       ThreadPool& pool, const std::optional<glm::dvec3>& up = {});

/// As view_facts(), but `choose(up)` chooses the framings if there are no cameras, best first.
ViewedScene view_facts_with(
    const Scene& scene, const std::optional<std::filesystem::path>& cameras_file,
    const std::optional<glm::dvec3>& up,
    const std::function<std::vector<Framing>(const std::optional<glm::dvec3>& up)>& choose);

/// The photographs in the folder `images` beside the cameras or one folder up, by index into
/// `cameras`.
std::map<int, std::filesystem::path> find_photographs(const std::filesystem::path& cameras_file,
                                                      const std::vector<Camera>& cameras);

}  // namespace qs
