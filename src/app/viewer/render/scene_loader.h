// SPDX-License-Identifier: MIT
//
// Reads what people open or drop, on a thread of its own: a scene with its cameras and photographs,
// cameras for the scene on show, or a path of keyframes. Nothing is shown before all of it was
// read.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "app/viewer/state/actions.h"
#include "io/scene/reader.h"

namespace qs {

/// A scene that was read, and what the viewer needs to know of it.
struct LoadedScene {
  Scene scene;
  ViewedScene facts;
};

/// Facts of a scene, with the cameras of `cameras_file` (found beside the scene when empty) and the
/// photographs in the folder `images` beside them. Throws Error when cameras_file is named and bad.
ViewedScene view_facts(const Scene& scene,
                       const std::optional<std::filesystem::path>& cameras_file);

/// The photographs of `images` beside the cameras or one folder up, by position in `cameras`.
std::map<int, std::filesystem::path> find_photographs(const std::filesystem::path& cameras_file,
                                                      const std::vector<Camera>& cameras);

class SceneLoader {
 public:
  /// `wake` is called from the loader's thread when poll() has something new. `threads` is the size
  /// of the pool that reads: 0 means one per hardware thread.
  explicit SceneLoader(std::function<void()> wake, int threads = 0)
      : wake_(std::move(wake)), threads_(threads) {}

  /// Starts reading; what was being read is cancelled.
  void start(const std::filesystem::path& path, int iteration = -1,
             const std::optional<std::filesystem::path>& cameras_file = std::nullopt,
             const std::string& axes = {});
  void cancel();

  /// A scene once it is read. Progress, cameras, keyframes and errors are appended to `actions`.
  std::optional<LoadedScene> poll(Actions& actions);

  /// Is something being read, or waiting to be polled?
  bool busy();

 private:
  void read(const std::filesystem::path& path, int iteration,
            const std::optional<std::filesystem::path>& cameras_file, const std::string& axes,
            const std::stop_token& stop);
  void report(Action action);

  std::function<void()> wake_;
  int threads_;
  std::mutex mutex_;  // of the next three
  bool reading_ = false;
  Actions reports_;
  std::optional<LoadedScene> loaded_;
  std::jthread thread_;
};

}  // namespace qs
