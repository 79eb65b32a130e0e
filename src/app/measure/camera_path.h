// SPDX-License-Identifier: MIT
//
// A smooth camera path through keyframes: a Catmull-Rom spline in time for position, rotation and
// the logarithm of the focal length. The path passes through every keyframe with continuous speed.
// A path file is a list of cameras in the layout of cameras.json, each with an optional "time" in
// seconds (default: one second apart), so every cameras.json is a path. At a keyframe with
// "ease": true the camera slows down to a stop.
// On the path of a zoom the camera keeps its orientation and moves along the line to a target. Its
// distance shrinks by the same factor at every step.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "raster/api/renderer.h"
#include "raster/scene/camera.h"

namespace qs {

struct Keyframe {
  double time = 0;  ///< seconds
  Camera camera;
  bool eases = false;  ///< the camera slows down to a stop here
};

/// Reads at least two keyframes with increasing times. Throws Error(input).
std::vector<Keyframe> read_camera_path(const std::filesystem::path& path);

/// The same from the text of a path file, of at least one keyframe. `name` stands in messages.
std::vector<Keyframe> parse_camera_path(const std::string& text, const std::string& name);

/// The text of a path file; read_camera_path() restores the keyframes exactly.
std::string format_camera_path(const std::vector<Keyframe>& keyframes);

/// The camera at `time`, clamped to the path, with the size and near plane of the first keyframe.
Camera camera_at(const std::vector<Keyframe>& keyframes, double time);

/// The path and the return to its begin: after the last keyframe the camera moves to the first
/// keyframe in the mean time between keyframes, with continuous speed. camera_at() is valid from
/// the first keyframe's time to closed_length() later.
std::vector<Keyframe> closed_path(const std::vector<Keyframe>& keyframes);

/// The seconds from the first keyframe through all others back to the first.
double closed_length(const std::vector<Keyframe>& keyframes);

/// `count` cameras at equal time steps from the first keyframe to the last, both included.
std::vector<Camera> sample_path(const std::vector<Keyframe>& keyframes, int count);

/// `steps` >= 2 cameras; the first is `start`, the last is `closest` (0..1, not 0) times the first
/// distance away from the target.
std::vector<Camera> zoom_path(const Camera& start, glm::dvec3 target, int steps, double closest);

/// The camera of zoom_path() with the number `step`, 0 to steps - 1.
Camera zoom_camera(const Camera& start, glm::dvec3 target, int steps, double closest, int step);

/// The pixel at the image's centre.
glm::ivec2 center_pixel(const Camera& camera);

/// The world position seen at a pixel, from the trace of one frame. Empty if the pixel is outside
/// the image or mostly transparent.
std::optional<glm::dvec3> find_point(Renderer& renderer, const Camera& camera,
                                     RenderSettings settings, glm::ivec2 pixel);

}  // namespace qs
