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
  const char *name, *arguments, *help;
  int words;  ///< least number of arguments
};

inline constexpr std::array kScriptCommands = {
    ScriptCommand{"wait", "", "waits until nothing is read, rendered or measured", 0},
    ScriptCommand{"key", "NAME", "presses and releases a key, for example Ctrl+O", 1},
    ScriptCommand{"keypad", "DIGIT", "presses and releases a digit of the keypad", 1},
    ScriptCommand{"hold", "NAME SECONDS", "keeps a key down", 2},
    ScriptCommand{"press", "NAME", "presses a key or a mouse button until it is released", 1},
    ScriptCommand{"release", "NAME", "releases it", 1},
    ScriptCommand{"move", "X Y", "moves the cursor to a pixel", 2},
    ScriptCommand{"click", "", "clicks the left button", 0},
    ScriptCommand{"doubleclick", "", "clicks it twice", 0},
    ScriptCommand{"drag", "DX DY BUTTON",
                  "moves the cursor with a button held: left, right or middle", 3},
    ScriptCommand{"wheel", "NOTCHES [MODIFIERS]", "turns the wheel", 1},
    ScriptCommand{"type", "TEXT", "types into a text field", 1},
    ScriptCommand{"drop", "PATH", "drops a file on the window", 1},
    ScriptCommand{"paste", "TEXT", "puts text on the clipboard", 1},
    ScriptCommand{"sleep", "SECONDS", "does nothing", 1},
    ScriptCommand{"shot", "FILE.png", "writes a picture of the window", 1},
    ScriptCommand{"state", "FILE.json", "writes what the window shows as JSON", 1},
    ScriptCommand{"quit", "", "closes the window", 0},
};

/// Throws Error(input) naming file and line.
std::vector<ScriptStep> read_script(const std::filesystem::path& path);

}  // namespace qs
