// SPDX-License-Identifier: MIT
//
// A script of what a person at the window would do, for tests and for pictures of the viewer. One
// command a line; empty lines and lines that begin with # are skipped. Commands: kScriptCommands.
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
  int words;  ///< arguments it takes at least
};

inline constexpr std::array kScriptCommands = {
    ScriptCommand{"wait", "", "until nothing is read, rendered or measured", 0},
    ScriptCommand{"key", "NAME", "presses and releases a key, for example Ctrl+O", 1},
    ScriptCommand{"keypad", "DIGIT", "the same with a digit of the keypad", 1},
    ScriptCommand{"hold", "NAME SECONDS", "keeps a key down", 2},
    ScriptCommand{"press", "NAME", "keeps a key or a button of the mouse down until it is released",
                  1},
    ScriptCommand{"release", "NAME", "lets it go", 1},
    ScriptCommand{"move", "X Y", "puts the cursor on a pixel", 2},
    ScriptCommand{"click", "", "presses and releases the left button", 0},
    ScriptCommand{"doubleclick", "", "twice", 0},
    ScriptCommand{"drag", "DX DY BUTTON", "with the button left, right or middle", 3},
    ScriptCommand{"wheel", "NOTCHES [MODIFIERS]", "turns the wheel", 1},
    ScriptCommand{"type", "TEXT", "into a text field", 1},
    ScriptCommand{"drop", "PATH", "drops a file on the window", 1},
    ScriptCommand{"paste", "TEXT", "puts text on the clipboard", 1},
    ScriptCommand{"sleep", "SECONDS", "does nothing", 1},
    ScriptCommand{"shot", "FILE.png", "writes the window as it is", 1},
    ScriptCommand{"state", "FILE.json", "writes what the window shows as text", 1},
    ScriptCommand{"quit", "", "closes the window", 0},
};

/// Throws Error(input) naming file and line.
std::vector<ScriptStep> read_script(const std::filesystem::path& path);

/// A key as key_name() prints it, "Ctrl+Shift+K". Throws Error(input).
struct KeyPress {
  int key = 0, mods = 0;
};
KeyPress parse_key(const std::string& name);

}  // namespace qs
