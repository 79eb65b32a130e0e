// SPDX-License-Identifier: MIT
//
// Identifies the measured scene, with a hash that shows if a file is still the measured one.
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "io/scene/reader.h"

namespace qs {

/// Name, file, hash, bytes and number of Gaussians.
nlohmann::ordered_json scene_facts(const Scene& scene, const std::string& name);

/// The name of a scene: its file's stem, or for point_cloud.ply the name of its model folder.
std::string scene_name(const std::filesystem::path& scene_file);

/// The line above a picture of a scene: "plush · camera 3".
std::string picture_title(const std::filesystem::path& scene_file, const std::string& view);

}  // namespace qs
