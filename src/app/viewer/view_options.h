// SPDX-License-Identifier: MIT
//
// Options of the command `view`, and the state that the viewer starts with.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "app/remote/tcp.h"
#include "app/session/session.h"
#include "app/viewer/state/viewer.h"

namespace qs {

class TrainingThread;

struct ViewOptions {
  FrameOptions frame;                  ///< scene empty: an empty window
  std::optional<std::string> beside;   ///< find_variant(): splits the window from the start
  std::filesystem::path beside_scene;  ///< splits the window with another scene; empty: none
  std::optional<TcpAddress> connect;   ///< shows a training in another program instead of a scene
  std::vector<Camera> remote_cameras;  ///< the cameras of its data set, may be empty
  bool vsync = true, interop = true;
  std::filesystem::path settings;               ///< preferences file; empty: nothing is kept
  std::optional<std::filesystem::path> script;  ///< input script, see input_script.h
  std::filesystem::path out_dir = ".";          ///< Viewer::out_dir
  /// A training run beside the window, which gives it its scene; see TrainingThread::Work. May be
  /// null.
  std::function<std::string(TrainingThread&)> train;
  /// Like `train`, for runs that the user starts in the window.
  std::function<std::string(TrainingThread&, const TrainingRequest&)> train_request;
};

/// True if the user has no preferences file yet: the bundled scene and hints are shown.
bool first_start(const ViewOptions& options);

/// The state at the start: from the preferences file, overridden by the options. Sets
/// `window_size`, screen units. Throws Error(usage) if ViewOptions::beside names no variant.
Viewer initial_viewer(const ViewOptions& options, glm::ivec2& window_size);

/// Opens the window and returns when it is closed. Throws Error.
void run_viewer(const ViewOptions& options);

}  // namespace qs
