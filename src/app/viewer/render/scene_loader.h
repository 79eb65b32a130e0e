// SPDX-License-Identifier: MIT
//
// Reads files that the user opens or drops, on a separate thread: a scene with its cameras and
// photographs, cameras for the scene in the window, or a camera path. Outcomes are reported as
// actions, after everything was read. Before that, a large scene's sample is reported, with the
// first view that is chosen from it. One photograph at a time is read on another thread.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "app/viewer/render/action_queue.h"
#include "app/viewer/render/open_scene.h"

namespace qs {

/// Facts of a scene, with the cameras of `cameras_file` (found beside the scene when empty) and the
/// photographs in the folder `images` beside them. `up`: as in FrameOptions. Throws Error if
/// `cameras_file` cannot be read.
ViewedScene view_facts(const Scene& scene, const std::optional<std::filesystem::path>& cameras_file,
                       ThreadPool& pool, const std::optional<glm::dvec3>& up = {});

/// The photographs in the folder `images` beside the cameras or one folder up, by index into
/// `cameras`.
std::map<int, std::filesystem::path> find_photographs(const std::filesystem::path& cameras_file,
                                                      const std::vector<Camera>& cameras);

struct OpenRequest {
  std::filesystem::path path;
  std::string axes;                                   ///< ReadOptions::axes
  int iteration = -1;                                 ///< ReadOptions::iteration
  std::optional<std::filesystem::path> cameras_file;  ///< unset: found beside the scene
  std::optional<glm::dvec3> up;                       ///< FrameOptions::up
  bool keep_background = false;                       ///< open_scene()
  bool skip_huge = false;                             ///< FrameOptions::skip_huge
  bool beside = false;                                ///< open_beside(), not open_scene()
};

class SceneLoader {
 public:
  /// `wake` is called on the loader's threads after every report. Scenes are read by `threads`
  /// threads; 0 = one per hardware thread.
  SceneLoader(std::function<void()> wake, int threads, Sampling sampling = {})
      : reports_(std::move(wake)), threads_(threads), sampling_(std::move(sampling)) {}

  /// Starts reading, and cancels earlier reading.
  void open(const OpenRequest& request);
  void cancel();

  void read_photograph(const std::filesystem::path& path);

  void take_reports(Actions& actions) { reports_.take(actions); }

  /// True while something is being read or a report waits to be taken.
  bool busy() { return reading_ > 0 || !reports_.empty(); }

 private:
  void read(const OpenRequest& request, const std::stop_token& stop);
  void read_beside(const std::filesystem::path& path, const ReadOptions& options, bool skip_huge,
                   const std::stop_token& stop);

  ActionQueue reports_;
  int threads_;
  Sampling sampling_;
  std::atomic<int> reading_ = 0;  // threads
  std::jthread thread_, photograph_thread_;
};

}  // namespace qs
