// SPDX-License-Identifier: MIT
//
// Which views a command renders: cameras of a file, one given as JSON, steps along a camera path,
// or a framing of the scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/frame_options.h"

namespace qs {

struct CameraChoice {
  std::optional<int> index;                   ///< position in the cameras file
  std::optional<std::string> json;            ///< one camera as text
  bool all = false;                           ///< every camera of the file
  std::optional<std::filesystem::path> path;  ///< keyframes, see bench/camera_path.h
  std::optional<int> frames;                  ///< along the path (default: kPathFrames)

  bool several() const { return all || path; }
};

inline constexpr int kPathFrames = 32;

struct Shot {
  Camera camera;
  int number = -1;     ///< position in the cameras file or on the path, -1 when it has none
  std::string origin;  ///< for people: "camera 3 (IMG_0004)", "path 0003", "framing"
};

void declare_camera_choice(Options& options, CameraChoice& choice);

/// At least one shot, at the size asked for. Without a choice: the first camera of the cameras
/// file, or a framing of the scene when there is no file. Throws Error.
std::vector<Shot> choose_shots(const CameraChoice& choice, const FrameOptions& frame,
                               const Scene& scene);

/// OUT.png -> OUT_0003_NAME.png for a numbered shot, OUT.png for others.
std::filesystem::path with_shot(const std::filesystem::path& path, const Shot& shot);

/// OUT.png -> OUT_WORD.png. Characters that are trouble in file names become '_'.
std::filesystem::path with_word(const std::filesystem::path& path, const std::string& word);

}  // namespace qs
