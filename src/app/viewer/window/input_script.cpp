// SPDX-License-Identifier: MIT
#include "app/viewer/window/input_script.h"

#include <algorithm>
#include <sstream>
#include <string>

#include "app/viewer/state/hud_text.h"
#include "base/fail.h"
#include "io/bytes/json_text.h"

namespace qs {

std::vector<ScriptStep> read_script(const std::filesystem::path& path) {
  constexpr std::size_t kMaxBytes = std::size_t{1} << 20;
  std::vector<ScriptStep> steps;
  std::istringstream lines(read_text_file(path, kMaxBytes));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    ScriptStep step;
    step.line = number;
    if (!(words >> step.command) || step.command.front() == '#') continue;
    const auto row = std::ranges::find(kScriptCommands, step.command, &ScriptCommand::name);
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

ScriptPlayer::ScriptPlayer(const std::filesystem::path& path) : path_(path) {
  const std::vector<ScriptStep> steps = read_script(path);
  steps_.assign(steps.begin(), steps.end());
}

std::optional<ScriptStep> ScriptPlayer::next(const Viewer& viewer, Host& host,
                                             const std::function<bool()>& at_rest) {
  constexpr double kPatience = 120;  // longest `wait`, seconds
  const double now = viewer.now;
  if (done() || now < sleeps_until_) return std::nullopt;
  const ScriptStep step = steps_.front();
  if (step.command == "wait" && !at_rest()) {
    if (now - waits_since_ < kPatience) return std::nullopt;
    fail("{}: line {}: still busy after {} seconds", path_.string(), step.line, kPatience);
  }
  steps_.pop_front();
  waits_since_ = now;
  if (step.command == "wait") return std::nullopt;
  if (step.command == "sleep") {
    sleeps_until_ = now + std::stod(step.words[0]);
  } else if (step.command == "shot") {
    host.grab_window(step.words[0], false);
  } else if (step.command == "state") {
    host.write_file(step.words[0], state_json(viewer));
  } else if (step.command == "quit") {
    host.quit();
  } else if (step.command == "drag") {
    steps_.push_front({"release", {step.words[2]}, step.line});
    steps_.push_front({"nudge", {step.words[0], step.words[1]}, step.line});
    return ScriptStep{"press", {step.words[2]}, step.line};
  } else if (step.command == "hold") {
    sleeps_until_ = now + std::stod(step.words[1]);
    steps_.push_front({"release", {step.words[0]}, step.line});
    return ScriptStep{"press", {step.words[0]}, step.line};
  } else {
    return step;
  }
  return std::nullopt;
}

}  // namespace qs
