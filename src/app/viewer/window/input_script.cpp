// SPDX-License-Identifier: MIT
#include "app/viewer/window/input_script.h"

#include <algorithm>
#include <sstream>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "app/viewer/state/bindings.h"
#include "io/bytes/json_text.h"
#include "raster/base/fail.h"

namespace qs {
namespace {
constexpr std::size_t kMaxBytes = std::size_t{1} << 20;
}  // namespace

std::vector<ScriptStep> read_script(const std::filesystem::path& path) {
  std::vector<ScriptStep> steps;
  std::istringstream lines(read_text_file(path, kMaxBytes));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    ScriptStep step;
    step.line = number;
    if (!(words >> step.command) || step.command.front() == '#') continue;
    const auto row =
        std::find_if(kScriptCommands.begin(), kScriptCommands.end(),
                     [&](const ScriptCommand& command) { return step.command == command.name; });
    if (row == kScriptCommands.end())
      fail("{}: line {}: there is no command '{}'", path.string(), number, step.command);
    // The last argument of a command with one may hold spaces: a text, a path.
    for (std::string word; words >> word;) {
      if (row->words == 1 && !step.words.empty() && step.command != "wheel") {
        step.words.back() += " " + word;
      } else {
        step.words.push_back(word);
      }
    }
    if (static_cast<int>(step.words.size()) < row->words)
      fail("{}: line {}: it is '{} {}'", path.string(), number, row->name, row->arguments);
    steps.push_back(std::move(step));
  }
  return steps;
}

KeyPress parse_key(const std::string& name) {
  KeyPress press;
  std::string rest = name;
  const auto modifier = [&](const char* word, int mod) {
    const std::string prefix = std::string(word) + "+";
    if (rest.starts_with(prefix)) {
      press.mods |= mod;
      rest.erase(0, prefix.size());
    }
  };
  modifier("Ctrl", GLFW_MOD_CONTROL);
  modifier("Alt", GLFW_MOD_ALT);
  modifier("Shift", GLFW_MOD_SHIFT);
  for (int key = GLFW_KEY_SPACE; key <= GLFW_KEY_LAST; ++key) {
    if (key_name(key) == rest) return press.key = key, press;
  }
  if (rest == "Escape") return press.key = GLFW_KEY_ESCAPE, press;
  if (rest == "Enter") return press.key = GLFW_KEY_ENTER, press;
  fail("there is no key '{}'", name);
}

}  // namespace qs
