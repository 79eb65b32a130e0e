// SPDX-License-Identifier: MIT
//
// Code shared by this project's renderers as plugins. The environment variables QS_OWN_MODE and
// QS_OWN_PIPELINE name a culling mode and a pipeline: quadbox and fast without them.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iterator>
#include <string>

#include "base/error.h"
#include "quadsplat/plugin.h"
#include "raster/api/renderer.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::own {

/// The index of the name that an environment variable has, in a table. Throws Error(usage).
template <class Find>
int chosen(const char* variable, const char* otherwise, const Find& find) {
  const char* const name = std::getenv(variable);
  const int found = find(std::string(name == nullptr ? otherwise : name));
  if (found < 0) throw Error(ErrorKind::usage, std::string(variable) + " has an unknown name");
  return found;
}

/// The settings of a process, for every view. Throws Error(usage).
inline RenderSettings settings() {
  RenderSettings settings;
  settings.mode = chosen("QS_OWN_MODE", "quadbox", [](const std::string& name) {
    const CullMode mode = find_culler(name);
    return mode == kReferenceMode ? -1 : mode;
  });
  settings.pipeline = static_cast<Pipeline>(chosen("QS_OWN_PIPELINE", "fast", [](const auto& name) {
    for (int i = 0; i < static_cast<int>(std::size(kPipelineNames)); ++i) {
      if (name == kPipelineNames[i]) return i;
    }
    return -1;
  }));
  return settings;
}

/// The cloud of a scene whose arrays are in host memory.
inline GaussianCloud cloud_of(const QsScene& scene) {
  GaussianCloud cloud;
  cloud.resize(scene.count, scene.sh_degree);
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(scene.sh_degree));
  const auto triple = [](const float* from, std::size_t i) {
    return glm::vec3(from[3 * i], from[3 * i + 1], from[3 * i + 2]);
  };
  for (std::size_t i = 0; i < scene.count; ++i) {
    const float* const q = scene.rotations + 4 * i;
    cloud.positions[i] = triple(scene.positions, i);
    cloud.log_scales[i] = triple(scene.log_scales, i);
    cloud.rotations[i] = glm::quat(q[0], q[1], q[2], q[3]);
    cloud.opacity_logits[i] = scene.opacity_logits[i];
    for (std::size_t k = 0; k < coefficients; ++k)
      cloud.sh[i * coefficients + k] = triple(scene.sh, i * coefficients + k);
  }
  return cloud;
}

inline void apply(const QsView& view, RenderSettings& settings) {
  settings.sh_degree = view.sh_degree;
  settings.splat_scale = view.splat_scale;
  settings.background = {view.background[0], view.background[1], view.background[2]};
  settings.antialiased = view.antialiased != 0;
  settings.dilation = view.dilation_px2;
}

inline Camera camera_of(const QsView& view) {
  Camera camera;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      camera.view_from_world[column][row] = view.view_from_world[4 * row + column];
  }
  camera.focal_px = {view.focal_px[0], view.focal_px[1]};
  camera.center_px = {view.center_px[0], view.center_px[1]};
  camera.width = view.width;
  camera.height = view.height;
  camera.near_depth = view.near_depth;
  return camera;
}

inline Outputs outputs_of(const QsFrame& frame) {
  Outputs outputs;
  outputs.stage_times = frame.mark_stages != 0;
  return outputs;
}

inline void report(const RenderStats& stats, QsFrame& frame) {
  frame.frame_ms = static_cast<double>(stats.frame_ms);
  for (int stage = 0; stage < kStageCount; ++stage)
    frame.stage_ms[stage] = static_cast<double>(stats.stage_ms[stage]);
  frame.pairs = stats.tile_pairs;
  frame.visible = stats.visible;
}

/// Calls `work`; an exception becomes a message and the code 1.
template <class Work>
int32_t guarded(char* message, const Work& work) {
  try {
    work();
    return 0;
  } catch (const std::exception& error) {
    std::snprintf(message, QS_MESSAGE_BYTES, "%s", error.what());
    return 1;
  }
}

}  // namespace qs::own
