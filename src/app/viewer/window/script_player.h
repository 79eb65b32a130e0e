// SPDX-License-Identifier: MIT
//
// Plays an input script: carries out the commands for the whole program (wait, sleep, shot, state,
// quit) and returns the commands for the window one by one.
#pragma once

#include <deque>
#include <functional>
#include <optional>

#include "app/viewer/state/action.h"
#include "app/viewer/state/viewer.h"
#include "app/viewer/window/input_script.h"

namespace qs {

class ScriptPlayer {
 public:
  ScriptPlayer() = default;

  /// Throws Error(input) naming file and line.
  explicit ScriptPlayer(const std::filesystem::path& path);

  bool done() const { return steps_.empty(); }

  /// Carries out at most one command, and returns it if it is for the window. `hold` and `drag`
  /// become `press`, `nudge DX DY` and `release` on successive calls. `at_rest`: no work is in
  /// progress. Throws Error if `wait` takes too long or a file cannot be written.
  std::optional<ScriptStep> next(const Viewer& viewer, Host& host,
                                 const std::function<bool()>& at_rest);

 private:
  std::filesystem::path path_;
  std::deque<ScriptStep> steps_;
  double sleeps_until_ = 0, waits_since_ = 0;  // Viewer::now
};

}  // namespace qs
