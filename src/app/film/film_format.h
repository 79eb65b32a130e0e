// SPDX-License-Identifier: MIT
//
// The formats of films. To add a format that ffmpeg can write: a row in film_format.cpp.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

namespace qs {

struct FilmFormat {
  std::string ending;  ///< with its dot; empty: a folder of PNG files, without ffmpeg
  std::vector<std::string> options = {};  ///< ffmpeg's options for the file
  bool even_size = false;                 ///< width and height must be even
  double most_fps = 240;                  ///< pictures per second

  bool folder() const { return ending.empty(); }
};

/// The format of a film with this name. Throws Error: usage for an unknown extension and for a size
/// or rate that the format cannot hold, device if it needs ffmpeg and ffmpeg is not installed.
const FilmFormat& film_format(const std::filesystem::path& path, glm::ivec2 size, double fps);

/// True if ffmpeg is on the PATH.
bool ffmpeg_is_installed();

}  // namespace qs
