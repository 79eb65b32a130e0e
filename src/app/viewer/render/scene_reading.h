// SPDX-License-Identifier: MIT
//
// Reads files that the user opens or drops, on the thread of SceneOpening: a scene with its cameras
// and photographs, cameras for the scene in the window, or a camera path. A large scene's sample is
// reported before the whole is read, with the first view that is chosen from it.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>

#include "app/session/scene_edits.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/viewer.h"
#include "io/scene/reader.h"

namespace qs {

struct OpenRequest {
  std::filesystem::path path;
  std::string axes;                                        ///< ReadOptions::axes
  int iteration = -1;                                      ///< ReadOptions::iteration
  std::optional<std::filesystem::path> cameras_file = {};  ///< unset: found beside the scene
  std::optional<glm::dvec3> up = {};                       ///< FrameOptions::up
  EditOptions edits = {};                                  ///< FrameOptions::edits
  bool keep_background = false;                            ///< settings_for()
  bool skip_huge = false;                                  ///< FrameOptions::skip_huge
  StreamedTrees streams = StreamedTrees::none;             ///< ReadOptions::streams
  bool beside = false;                                     ///< beside the scene in the window
};

/// A sample of a scene that is being read, and the facts that the viewer shows of it.
struct ReadSample {
  std::shared_ptr<SceneSample> sample;  ///< drawing it may take its cloud
  ViewedScene facts;
};

/// A scene that was read, and its facts for the viewer; without facts if it is shown beside the
/// scene in the window.
struct LoadedScene {
  std::shared_ptr<const Scene> scene;
  ViewedScene facts = {};
};

using ReadingReport = std::variant<Loading, ReadSample, LoadedScene, OpeningResult>;

/// Reads with `threads` threads; 0 = one per hardware thread. Calls `report` on this thread and on
/// a separate thread. The last report is a loaded scene or the result. Throws Error and Cancelled.
void read_to_open(const OpenRequest& request, int threads, Sampling sampling,
                  const std::function<void(ReadingReport)>& report, const std::stop_token& stop);

// ---- the facts of a scene that the viewer keeps, and the files beside it
// -------------------------
/// Facts of a scene, with the cameras of `cameras_file` (found beside the scene when empty) and the
/// photographs in the folder `images` beside them. `up`: as in FrameOptions. Throws Error if
/// `cameras_file` cannot be read.
ViewedScene view_facts(const Scene& scene, const std::optional<std::filesystem::path>& cameras_file,
                       ThreadPool& pool, const std::optional<glm::dvec3>& up = {});

/// As view_facts(), but `choose(up)` chooses the framings if there are no cameras, best first.
ViewedScene view_facts_with(
    const Scene& scene, const std::optional<std::filesystem::path>& cameras_file,
    const std::optional<glm::dvec3>& up,
    const std::function<std::vector<Framing>(const std::optional<glm::dvec3>& up)>& choose);

/// The photographs in the folder `images` beside the cameras or one folder up, by index into
/// `cameras`.
std::map<int, std::filesystem::path> find_photographs(const std::filesystem::path& cameras_file,
                                                      const std::vector<Camera>& cameras);

}  // namespace qs
