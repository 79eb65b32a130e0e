// SPDX-License-Identifier: MIT
//
// The choice of the views that a command renders: cameras of a file, one camera given as JSON,
// steps along a camera path, or a view that frames the scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/cli/shared_options.h"
#include "app/session/shot.h"

namespace qs {

struct CameraChoice {
  std::vector<int> indices;                   ///< positions in the cameras file
  std::optional<std::string> json;            ///< one camera as text
  bool all = false;                           ///< every camera of the file
  std::optional<std::filesystem::path> path;  ///< keyframes, see measure/camera_path.h
  std::optional<int> steps;                   ///< along the path (default: kPathSteps)
  int holdout = 0;  ///< every N-th camera by name, from the first, as `eval --holdout`; 0: unset
  bool usually_all = false;  ///< every camera if nothing is chosen, else the first

  bool several() const { return all || path || indices.size() > 1 || holdout > 0; }
};

inline constexpr int kPathSteps = 32;

/// --camera-index: numbers separated by commas.
void declare_camera_index_option(Options& options, std::vector<int>& indices,
                                 const std::string& usual, const Options::Samples& samples);

/// --path-steps.
void declare_path_steps_option(Options& options, std::optional<int>& steps);

void declare_camera_choice(Options& options, CameraChoice& choice);

/// Throws Error(usage) unless one camera and one mode with tiles are chosen. `command`: its name.
void require_one_picture(const char* command, const CameraChoice& choice,
                         const FrameOptions& frame);

/// At least one shot, resized to frame.size. Without a choice: the first camera of the cameras
/// file, or choose_framing() in 1280 x 720 pixels if there is no file. Throws Error.
std::vector<Shot> choose_shots(const CameraChoice& choice, const FrameOptions& frame,
                               const Session& session);

/// The same, but every camera of the cameras file if nothing was chosen and there is such a file.
std::vector<Shot> choose_shots_or_all(CameraChoice choice, const FrameOptions& frame,
                                      const Session& session);

/// The cameras of the cameras file; empty without a file. Throws Error.
std::vector<Camera> cameras_of(const FrameOptions& frame, const Scene& scene);

/// A view of the scene's whole core, at frame.size or 1280 x 720.
Shot overview_shot(const FrameOptions& frame, const Scene& scene);

}  // namespace qs
