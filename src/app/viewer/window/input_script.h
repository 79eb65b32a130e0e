// SPDX-License-Identifier: MIT
//
// A script of user input, for tests and for pictures of the viewer. One command per line; empty
// lines and lines that begin with # are skipped.
#pragma once

#include <array>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "app/viewer/state/action.h"
#include "app/viewer/state/viewer.h"

namespace qs {

struct ScriptStep {
  std::string command;
  std::vector<std::string> words;  ///< after the command
  int line = 0;
};

struct ScriptCommand {
  const char *name, *arguments;
  int words;  ///< least number of arguments
};

/// docs/viewer.md describes them.
inline constexpr std::array kScriptCommands = {
    ScriptCommand{"wait", "", 0},
    ScriptCommand{"key", "NAME", 1},
    ScriptCommand{"keypad", "DIGIT", 1},
    ScriptCommand{"hold", "NAME SECONDS", 2},
    ScriptCommand{"press", "NAME", 1},
    ScriptCommand{"release", "NAME", 1},
    ScriptCommand{"move", "X Y", 2},
    ScriptCommand{"click", "", 0},
    ScriptCommand{"doubleclick", "", 0},
    ScriptCommand{"drag", "DX DY BUTTON", 3},
    ScriptCommand{"wheel", "NOTCHES [MODIFIERS]", 1},
    ScriptCommand{"type", "TEXT", 1},
    ScriptCommand{"drop", "PATH", 1},
    ScriptCommand{"paste", "TEXT", 1},
    ScriptCommand{"crop", "BOX|floaters|nothing", 1},
    ScriptCommand{"zoom", "NAME=VALUE ...", 1},
    ScriptCommand{"sleep", "SECONDS", 1},
    ScriptCommand{"shot", "FILE.png", 1},
    ScriptCommand{"state", "FILE.json", 1},
    ScriptCommand{"quit", "", 0},
};

/// Throws Error(input) naming file and line.
std::vector<ScriptStep> read_script(const std::filesystem::path& path);

/// Plays an input script: carries out the commands for the whole program (wait, sleep, shot, state,
/// quit) and returns the commands for the window one by one.
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
