// SPDX-License-Identifier: MIT
//
// A script of user input, for tests and for pictures of the viewer. One command per line; empty
// lines and lines that begin with # are skipped.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

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

}  // namespace qs
