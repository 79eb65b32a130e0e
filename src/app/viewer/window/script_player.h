// SPDX-License-Identifier: MIT
//
// Hands out the steps of an input script when their time has come.
#pragma once

#include <deque>
#include <functional>
#include <optional>

#include "app/viewer/window/input_script.h"

namespace qs {

class ScriptPlayer {
 public:
  ScriptPlayer() = default;

  /// Throws Error(input) naming file and line.
  explicit ScriptPlayer(const std::filesystem::path& path);

  bool done() const { return steps_.empty(); }

  /// The step to carry out now, if any. `wait` and `sleep` are its own business; of `hold` and
  /// `drag` it makes `press`, `nudge DX DY` and `release`, a turn each. `at_rest` says whether
  /// there is nothing left to wait for. Throws Error when `wait` takes too long.
  std::optional<ScriptStep> next(double now, const std::function<bool()>& at_rest);

 private:
  std::filesystem::path path_;
  std::deque<ScriptStep> steps_;
  double sleeps_until_ = 0, waits_since_ = 0;  // seconds
};

}  // namespace qs
