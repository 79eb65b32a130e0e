// SPDX-License-Identifier: MIT
#include "app/viewer/window/input_script.h"

#include <algorithm>
#include <sstream>

#include "base/fail.h"
#include "io/bytes/json_text.h"

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
    // A single argument may hold spaces: a text, a path.
    for (std::string word; words >> word;) {
      if (row->words == 1 && !step.words.empty() && step.command != "wheel") {
        step.words.back() += " " + word;
      } else {
        step.words.push_back(word);
      }
    }
    if (static_cast<int>(step.words.size()) < row->words)
      fail("{}: line {}: expected '{} {}'", path.string(), number, row->name, row->arguments);
    steps.push_back(std::move(step));
  }
  return steps;
}

}  // namespace qs
