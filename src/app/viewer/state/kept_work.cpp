// SPDX-License-Identifier: MIT
#include "app/viewer/state/kept_work.h"

#include <fmt/format.h>

#include "app/viewer/state/actions.h"
#include "app/viewer/state/edit_actions.h"
#include "app/viewer/state/measure_actions.h"
#include "base/error.h"
#include "base/text.h"

namespace qs {
namespace {

// "3 keyframes", "a crop": the parts that there are. One keyframe is no path.
std::vector<std::string> work_of(const Viewer& v) {
  std::vector<std::string> parts;
  if (v.keyframes.size() > 1) parts.push_back(fmt::format("{} keyframes", v.keyframes.size()));
  if (v.editing.steps > 0) parts.emplace_back("a crop");
  return parts;
}

bool is_filming(const Viewer& v) { return v.loading && v.loading->what == kFilming; }

}  // namespace

// Work refers to the axes that the file was read with.
std::string work_name(const ViewedScene& scene) {
  return fmt::format("{} {}", scene.path.string(), scene.axes);
}

std::string unsaved_text(const Viewer& v, const std::filesystem::path& opens) {
  std::vector<std::string> parts;
  if (v.scene && !v.keeps_work) parts = work_of(v);
  if (v.scene && v.keeps_work && v.editing.steps > 0 && !v.editing.saved && !v.editing.keeps)
    parts.emplace_back("edits (Ctrl+S saves them)");
  if (measures_are_unsaved(v)) parts.emplace_back("measures");
  if (opens.empty() && !v.unsaved_results.empty()) parts.push_back("a " + v.unsaved_results);
  if (v.zoom.running) parts.emplace_back("a zoom that is being recorded");
  if (is_filming(v))
    parts.push_back(fmt::format("a film of which {:.0f} % are drawn", 100 * v.loading->fraction));
  return joined(parts, " and ");
}

namespace action {

void keep_work(Viewer& v) {
  if (!v.scene) return;
  const std::string name = work_name(*v.scene);
  v.kept_paths.erase(name);
  if (!v.keyframes.empty()) v.kept_paths[name] = format_camera_path(v.keyframes);
}

void restore_work(Viewer& v, bool another) {
  const std::string name = work_name(*v.scene);
  v.crop = {};
  v.editing = Editing();
  v.selecting = {};
  v.cross.reset();
  if (another) {
    v.measures = {};
    v.keyframes.clear();
    v.keyframe_history = {};
  }
  try {
    if (const auto kept = v.kept_paths.find(name); another && kept != v.kept_paths.end())
      v.keyframes = parse_camera_path(kept->second, "settings");
  } catch (const Error&) {  // the settings were edited by hand
  }
  const std::string work = joined(work_of(v), " and ");
  if (another && !work.empty()) notify(v, fmt::format("restored {} of this scene", work));
}

void leave(Viewer& v, Host& host, const std::filesystem::path& opens) {
  // Cameras and paths of cameras join the scene.
  const bool joins = opens.extension() == ".json";
  if (joins || unsaved_text(v, opens).empty()) return leave_now(v, host, opens, true);
  v.leaving = opens;
}

void leave_now(Viewer& v, Host& host, const std::filesystem::path& opens, bool keeps) {
  v.leaving.reset();
  if (v.zoom.running || is_filming(v)) host.leave_job(keeps);
  if (keeps && edits_are_to_keep(v)) return keep_edits(v, host, call(leave, opens));
  if (keeps && measures_are_to_keep(v)) return keep_measures(v, host, call(leave, opens));
  opens.empty() ? host.quit() : host.open(opens, {});
}

}  // namespace action
}  // namespace qs
