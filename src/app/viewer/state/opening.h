// SPDX-License-Identifier: MIT
//
// The result of opening a file, as plain data: the opened scene, a sentence on why nothing was
// opened, or that it was cancelled. render/scene_opening.h owns the steps; Viewer::loading is their
// progress.
#pragma once

#include <string>
#include <variant>

#include "app/viewer/state/viewer.h"

namespace qs {

/// The scene that the render thread draws from now on.
struct OpenedScene {
  ViewedScene facts;
  RenderSettings settings;  ///< but for the mode, which stays the user's
  Backend backend = Backend::cpu;
};

/// Cameras for the scene in the window.
struct OpenedCameras {
  std::vector<Camera> cameras;
  std::filesystem::path file;
  std::map<int, std::filesystem::path> photographs;  ///< by index into `cameras`
};

/// A camera path.
struct OpenedPath {
  std::vector<Keyframe> keyframes;
};

struct OpeningFailed {
  std::string sentence;
};

struct OpeningCancelled {
  std::string sentence;  ///< empty: nothing is said
};

using OpeningResult = std::variant<OpenedScene, SceneBeside, OpenedCameras, OpenedPath,
                                   OpeningFailed, OpeningCancelled>;

}  // namespace qs
