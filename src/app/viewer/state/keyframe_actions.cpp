// SPDX-License-Identifier: MIT
//
// The keyframes of the camera path: setting, timing, playing and saving them.
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "base/path_kind.h"
#include "base/text.h"
#include "io/bytes/file_guard.h"

namespace qs::action {

namespace {

// Keeps the keyframes for Ctrl+Z before they change. `dragged`: the keyframe whose time changes;
// quick changes of one time are one step, because it is dragged.
void before_change(Viewer& v, std::ptrdiff_t dragged = -1) {
  constexpr std::size_t kMost = 100;
  constexpr double kDragSeconds = 1;
  KeyframeHistory& history = v.keyframe_history;
  const bool goes_on =
      dragged >= 0 && dragged == history.dragged && v.now - history.changed < kDragSeconds;
  history.dragged = dragged;
  history.changed = v.now;
  history.later.clear();
  if (goes_on) return;
  history.earlier.push_back(v.keyframes);
  if (history.earlier.size() > kMost) history.earlier.erase(history.earlier.begin());
}

}  // namespace

void step_keyframes(Viewer& v, bool back) {
  KeyframeHistory& history = v.keyframe_history;
  auto& from = back ? history.earlier : history.later;
  auto& to = back ? history.later : history.earlier;
  if (from.empty()) return notify(v, "no change of the keyframes is left");
  to.push_back(std::exchange(v.keyframes, std::move(from.back())));
  from.pop_back();
  history.dragged = -1;
  v.playback = {};
  notify(v, fmt::format("the path has {} keyframes", v.keyframes.size()));
}

void add_keyframe(Viewer& v) {
  before_change(v);
  v.keyframes.push_back({v.keyframes.empty() ? 0 : v.keyframes.back().time + 1, v.camera});
  notify(v, fmt::format("keyframe {} set", v.keyframes.size()));
}

void remove_keyframe(Viewer& v, std::size_t index) {
  if (index >= v.keyframes.size()) return;
  before_change(v);
  v.keyframes.erase(v.keyframes.begin() + static_cast<std::ptrdiff_t>(index));
  v.playback = {};
}

void ease_keyframe(Viewer& v, std::size_t index, bool eases) {
  if (index >= v.keyframes.size()) return;
  before_change(v);
  v.keyframes[index].eases = eases;
}

void delay_keyframe(Viewer& v, std::size_t index, double seconds) {
  constexpr double kLeast = 0.05, kMost = 3600;
  if (index == 0 || index >= v.keyframes.size()) return;
  before_change(v, static_cast<std::ptrdiff_t>(index));
  const double before = v.keyframes[index - 1].time;
  const double later = before + std::clamp(seconds, kLeast, kMost) - v.keyframes[index].time;
  for (std::size_t i = index; i < v.keyframes.size(); ++i) v.keyframes[i].time += later;
  v.playback = {};
}

void set_keyframes(Viewer& v, const std::vector<Keyframe>& keyframes) {
  before_change(v);
  v.keyframes = keyframes;
  v.playback = {};
  notify(v, fmt::format("opened a path of {}: Space plays it",
                        counted(v.keyframes.size(), "keyframe")));
}

void toggle_playback(Viewer& v) {
  if (v.keyframes.size() < 2) return notify(v, "a path needs two keyframes: set them with K");
  v.playback.running = !v.playback.running;
  if (v.playback.time >= v.path_end()) v.playback.time = v.keyframes.front().time;
}

void seek(Viewer& v, double time) {
  if (v.keyframes.size() < 2) return;
  v.playback.time = std::clamp(time, v.keyframes.front().time, v.path_end());
  const Camera camera =
      camera_at(v.loops_path ? closed_path(v.keyframes) : v.keyframes, v.playback.time);
  move(v, camera.resized(v.camera.width, v.camera.height));
}

void save_keyframes(Viewer& v, Host& host) {
  if (!v.scene || v.keyframes.size() < 2) return;
  const std::filesystem::path usual = v.out_dir / (v.scene->name + "_path.json");
  const std::filesystem::path path = own_name(usual);
  const bool replaces = is_there(path);
  std::vector<Keyframe> saved = v.keyframes;
  for (Keyframe& keyframe : saved) keyframe.camera.origin = v.scene->origin;
  host.write_file(path, format_camera_path(saved));
  notify_file(v, path,
              path != usual ? fmt::format("; {} is not a path of this program and stays",
                                          usual.filename().string())
              : replaces    ? ", in place of the path that was saved before"
                            : "");
}

}  // namespace qs::action
