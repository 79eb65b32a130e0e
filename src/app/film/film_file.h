// SPDX-License-Identifier: MIT
//
// Writes the pictures of a film to a file or folder, which appears whole or not at all. To add a
// format that ffmpeg can write: a row in film_file.cpp.
#pragma once

#include <filesystem>
#include <functional>

#include <glm/vec2.hpp>

#include "raster/scene/image.h"

namespace qs {

/// True if ffmpeg is on the PATH.
bool ffmpeg_is_installed();

/// Takes the next picture of a film: RGB, of the film's size.
using AddPicture = std::function<void(const Image& picture)>;

/// Throws Error: usage for an unknown extension, for a size or rate that the format cannot hold,
/// and if a command may not write a film to `path`, because it exists (io/bytes/file_guard.h);
/// device if the format needs ffmpeg and ffmpeg is not installed.
void check_film(const std::filesystem::path& path, glm::ivec2 size, double fps);

/// Calls draw(add), which adds the pictures in order, and moves the finished file or folder to
/// `path`. The name of `path` determines the format. A folder holds
/// frame_00000.png and so on; pictures of an earlier, longer film are removed. Throws what draw()
/// throws, and Error.
void write_film_file(const std::filesystem::path& path, glm::ivec2 size, double fps,
                     const std::function<void(const AddPicture& add)>& draw);

}  // namespace qs
