// SPDX-License-Identifier: MIT
//
// An ffmpeg process that encodes pictures, which it reads from this program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "base/child_process.h"
#include "raster/scene/image.h"

namespace qs {

class Ffmpeg {
 public:
  /// Starts the process, which writes `output`; messages call it `name`. `options`:
  /// FilmFormat::options. Signals of the terminal do not reach the process. Throws Error(device) if
  /// it cannot be started. The process is killed unless finish() is called.
  Ffmpeg(const std::filesystem::path& output, std::string name, glm::ivec2 size, double fps,
         const std::vector<std::string>& options);

  /// Sends an RGB picture of the film's size to ffmpeg. Throws Error(input) with ffmpeg's message
  /// if it has ended.
  void add(const Image& picture);

  /// Waits until the file is complete. Throws as add().
  void finish();

 private:
  std::string first_message() const;

  std::string name_;
  ChildProcess process_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace qs
