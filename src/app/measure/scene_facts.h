// SPDX-License-Identifier: MIT
//
// Which scene was measured: enough to notice that a file is not the one that an old result is of.
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "io/scene/reader.h"

namespace qs {

/// "crc32:89abcdef" of a file's content. Throws Error(input).
std::string file_hash(const std::filesystem::path& path);

/// Name, file, hash, bytes and number of Gaussians.
nlohmann::ordered_json scene_facts(const Scene& scene, const std::string& name);

/// What to call a scene: its file's stem, or for point_cloud.ply its model's folder.
std::string scene_name(const std::filesystem::path& scene_file);

}  // namespace qs
