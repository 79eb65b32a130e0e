// SPDX-License-Identifier: MIT
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "io/cloud/axes.h"

namespace qs {
namespace {

// The frames that Y tries after the frame that the file declares. Files with y down may have z up,
// as tools for maps and games write them; files of a format with y up may hold values as trained.
// Then come the other turns about the vertical axis, and mirrored frames. A scene that seems to be
// upside down is turned over first.
std::vector<std::string> frames_to_try(const std::string& declared, bool upside_down) {
  const bool y_up = declared.size() == 3 && declared[1] == 'U';
  std::vector<std::string> frames = {"RFU", "RUB", "RDF", "RBD", "LUF",
                                     "LDB", "LDF", "RUF", "RDB", "LUB"};
  if (y_up) std::swap(frames[0], frames[2]);
  if (upside_down) {
    const std::string first = turned_over(declared);
    std::erase(frames, first);
    frames.insert(frames.begin(), first);
  }
  std::erase(frames, declared);
  return frames;
}

// Reads the scene's file with these axes; empty: as the file declares them.
void read_with_axes(Viewer& v, Host& host, const std::string& axes) {
  const std::string path = v.scene->path.string();
  v.axes.erase(path);
  v.ups.erase(path);  // they were given in the previous axes
  if (!axes.empty()) v.axes[path] = axes;
  host.open(v.scene->path, axes);
}

}  // namespace

void action::next_axes(Viewer& v, Host& host) {
  if (!v.scene) return;
  std::vector<std::string>& frames = v.axes_to_try;
  const std::string& now = v.scene->axes;
  if (now.empty() || std::ranges::count(frames, now) == 0)
    frames = frames_to_try(v.scene->declared_axes, now.empty() && v.scene->framing.upside_down);
  auto next = now.empty() ? frames.begin() : std::ranges::find(frames, now);
  if (!now.empty() && next != frames.end()) ++next;
  const std::string axes(next == frames.end() ? "" : *next);
  notify(v, axes.empty() ? "axes as the file declares them"
                         : fmt::format("read as if its axes were {}; Y again for others", axes));
  read_with_axes(v, host, axes);
}

void action::turn_over(Viewer& v, Host& host) {
  if (!v.scene) return;
  const std::string& declared = v.scene->declared_axes;
  const std::string turned = qs::turned_over(v.scene->axes.empty() ? declared : v.scene->axes);
  notify(v, fmt::format("turned over: read as if its axes were {}; Shift+Y turns it back", turned));
  read_with_axes(v, host, turned == declared ? "" : turned);
}

}  // namespace qs
