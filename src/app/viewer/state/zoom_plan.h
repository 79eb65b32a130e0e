// SPDX-License-Identifier: MIT
//
// The plan of a recorded zoom: all that the panel "Zoom recorder" sets and the recording job reads.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>

#include "raster/api/renderer.h"

namespace qs {

inline constexpr int kFewestZoomSteps = 2, kMostZoomSteps = 200;
inline constexpr int kFewestZoomFrames = 20, kMostZoomFrames = 1000;
inline constexpr int kZoomWarmUp = 3;  ///< untimed frames per mode, before every step
inline constexpr double kLeastCloser = 1.1, kMostCloser = 1000;
inline constexpr int kMostZoomSide = 8192;  ///< pixels

/// The sizes that the panel offers; the first stands for the size of the picture in the window.
inline constexpr std::array<glm::ivec2, 4> kZoomSizes = {
    {{0, 0}, {1280, 720}, {1600, 1200}, {1920, 1080}}};

/// The path is zoom_path(): from the start to the point in the middle of its picture.
struct ZoomPlan {
  std::optional<Camera> start;  ///< unset: the view when the recording begins
  double closer = 20;           ///< first distance to the target / last distance
  int steps = 12;
  int frames = kFewestZoomFrames;    ///< timed, per mode and step
  std::vector<CullMode> modes;       ///< sorted; empty: all
  glm::ivec2 size{0};                ///< pixels; 0: as the picture in the window
  std::optional<Pipeline> pipeline;  ///< unset: the window's

  bool operator==(const ZoomPlan& other) const;
};

/// The plan with all values in their ranges. Everything that changes a plan goes through here.
ZoomPlan clamped_plan(ZoomPlan plan, Backend backend);

/// The modes that are measured, never empty.
std::vector<CullMode> zoom_modes(const ZoomPlan& plan);

/// The first camera of the path. `view`: the camera of the window, at its size.
Camera zoom_start(const ZoomPlan& plan, const Camera& view);

/// Frames that are rendered per mode and step, untimed ones included.
int zoom_frames(const ZoomPlan& plan, Backend backend);

}  // namespace qs
