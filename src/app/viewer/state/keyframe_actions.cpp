// SPDX-License-Identifier: MIT
//
// The keyframes of the camera path: setting, timing, playing and saving them.
#include <algorithm>

#include <fmt/format.h>

#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "base/text.h"
#include "io/bytes/file_guard.h"

namespace qs::action {

void add_keyframe(Viewer& v) {
  const double time = v.keyframes.empty() ? 0 : v.keyframes.back().time + 1;
  v.keyframes.push_back({time, v.camera});
  notify(v, fmt::format("keyframe {} set", v.keyframes.size()));
}

void remove_keyframe(Viewer& v, std::size_t index) {
  if (index >= v.keyframes.size()) return;
  v.keyframes.erase(v.keyframes.begin() + static_cast<std::ptrdiff_t>(index));
  v.playback = {};
}

void ease_keyframe(Viewer& v, std::size_t index, bool eases) {
  if (index < v.keyframes.size()) v.keyframes[index].eases = eases;
}

void delay_keyframe(Viewer& v, std::size_t index, double seconds) {
  constexpr double kLeast = 0.05, kMost = 3600;
  if (index == 0 || index >= v.keyframes.size()) return;
  const double before = v.keyframes[index - 1].time;
  const double later = before + std::clamp(seconds, kLeast, kMost) - v.keyframes[index].time;
  for (std::size_t i = index; i < v.keyframes.size(); ++i) v.keyframes[i].time += later;
  v.playback = {};
}

void set_keyframes(Viewer& v, const std::vector<Keyframe>& keyframes) {
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
  std::error_code error;
  const bool replaces = std::filesystem::exists(path, error);
  host.write_file(path, format_camera_path(v.keyframes));
  notify_file(v, path,
              path != usual ? fmt::format("; {} is not a path of this program and stays",
                                          usual.filename().string())
              : replaces    ? ", in place of the path that was saved before"
                            : "");
}

}  // namespace qs::action
