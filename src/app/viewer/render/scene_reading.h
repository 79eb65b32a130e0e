// SPDX-License-Identifier: MIT
//
// Reads files that the user opens or drops, on the thread of SceneOpening: a scene with its cameras
// and photographs, cameras for the scene in the window, or a camera path. A large scene's sample is
// reported before the whole is read, with the first view that is chosen from it.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>

#include "app/viewer/state/opening.h"
#include "io/scene/reader.h"

namespace qs {

struct OpenRequest {
  std::filesystem::path path;
  std::string axes;                                   ///< ReadOptions::axes
  int iteration = -1;                                 ///< ReadOptions::iteration
  std::optional<std::filesystem::path> cameras_file;  ///< unset: found beside the scene
  std::optional<glm::dvec3> up;                       ///< FrameOptions::up
  bool keep_background = false;                       ///< settings_for()
  bool skip_huge = false;                             ///< FrameOptions::skip_huge
  bool beside = false;                                ///< beside the scene in the window
};

/// A sample of a scene that is being read, and the facts that the viewer shows of it.
struct ReadSample {
  std::shared_ptr<SceneSample> sample;  ///< drawing it may take its cloud
  ViewedScene facts;
};

/// A scene that was read, and its facts for the viewer.
struct LoadedScene {
  std::shared_ptr<const Scene> scene;
  ViewedScene facts;
};

/// A scene that was read, to show beside the scene in the window.
struct LoadedBeside {
  std::shared_ptr<const Scene> scene;
};

using ReadingReport = std::variant<Loading, ReadSample, LoadedScene, LoadedBeside, OpeningResult>;

/// Reads with `threads` threads; 0 = one per hardware thread. Calls `report` on this thread and on
/// a separate thread. The last report is a loaded scene or the result. Throws Error and Cancelled.
void read_to_open(const OpenRequest& request, int threads, Sampling sampling,
                  const std::function<void(ReadingReport)>& report, const std::stop_token& stop);

}  // namespace qs
