// SPDX-License-Identifier: MIT
#include "app/viewer/window/script_player.h"

#include <string>

#include "app/viewer/state/hud_text.h"
#include "base/fail.h"

namespace qs {
namespace {
constexpr double kPatience = 120;  ///< longest `wait`, seconds
}  // namespace

ScriptPlayer::ScriptPlayer(const std::filesystem::path& path) : path_(path) {
  const std::vector<ScriptStep> steps = read_script(path);
  steps_.assign(steps.begin(), steps.end());
}

std::optional<ScriptStep> ScriptPlayer::next(const Viewer& viewer, Host& host,
                                             const std::function<bool()>& at_rest) {
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
