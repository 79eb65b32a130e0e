// SPDX-License-Identifier: MIT
//
// Writes the pictures of a film to a file or folder, which appears whole or not at all.
#pragma once

#include <filesystem>
#include <functional>

#include <glm/vec2.hpp>

#include "raster/scene/image.h"

namespace qs {

/// Takes the next picture of a film: RGB, of the film's size.
using AddPicture = std::function<void(const Image& picture)>;

/// Throws Error(usage) if a command may not write a film to `path`, because it exists
/// (io/bytes/file_guard.h).
void check_film_target(const std::filesystem::path& path);

/// Calls draw(add), which adds the pictures in order, and moves the finished file or folder to
/// `path`. The name of `path` determines the format, see film_format.h. A folder holds
/// frame_00000.png and so on; pictures of an earlier, longer film are removed. Throws what draw()
/// throws, and Error.
void write_film_file(const std::filesystem::path& path, glm::ivec2 size, double fps,
                     const std::function<void(const AddPicture& add)>& draw);

}  // namespace qs
