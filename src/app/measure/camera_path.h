// SPDX-License-Identifier: MIT
//
// A smooth camera path through keyframes: a Catmull-Rom spline in time for position, rotation and
// the logarithm of the focal length. The path passes through every keyframe with continuous speed.
// A path file is a list of cameras in the layout of cameras.json, each with an optional "time" in
// seconds (default: one second apart), so every cameras.json is a path.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "raster/scene/camera.h"

namespace qs {

struct Keyframe {
  double time = 0;  ///< seconds
  Camera camera;
};

/// Reads at least two keyframes with increasing times. Throws Error(input).
std::vector<Keyframe> read_camera_path(const std::filesystem::path& path);

/// The text of a path file; read_camera_path() restores the keyframes exactly.
std::string format_camera_path(const std::vector<Keyframe>& keyframes);

/// The camera at `time`, clamped to the path, with the size and near plane of the first keyframe.
Camera camera_at(const std::vector<Keyframe>& keyframes, double time);

/// `count` cameras at equal time steps from the first keyframe to the last, both included.
std::vector<Camera> sample_path(const std::vector<Keyframe>& keyframes, int count);

}  // namespace qs
