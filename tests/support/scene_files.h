// SPDX-License-Identifier: MIT
//
// read_scene() and write_scene() with a thread pool of their own, for tests in which the number of
// threads does not matter, and write_cameras().
#pragma once

#include <vector>

#include "io/scene/reader.h"
#include "io/scene/writer.h"
#include "raster/scene/camera.h"

namespace qs::test {

Scene read_scene(const std::filesystem::path& path, const ReadOptions& options = {});
const WriterRow& write_scene(const GaussianCloud& cloud, const std::filesystem::path& path,
                             const Progress& progress = {}, std::string_view format = {});

/// A file in the layout of cameras.json.
void write_cameras(const std::vector<Camera>& cameras, const std::filesystem::path& path);

}  // namespace qs::test
