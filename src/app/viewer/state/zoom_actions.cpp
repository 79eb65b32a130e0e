// SPDX-License-Identifier: MIT
#include "app/viewer/state/zoom_actions.h"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>

#include "app/viewer/state/actions.h"
#include "base/fail.h"
#include "base/text.h"

namespace qs::action {
namespace {

std::vector<CullMode> parse_zoom_modes(const std::string& names) {
  std::vector<CullMode> modes;
  for (const std::string& name : separated(names)) {
    const CullMode mode = find_culler(name);
    if (mode < 1 || mode > culler_count())
      fail(ErrorKind::usage, "zoom: '{}' is not one of the modes of the recorder", name);
    modes.push_back(mode);
  }
  return modes;
}

void set_part(ZoomPlan& plan, const std::string& name, const std::string& value) {
  if (name == "steps") {
    plan.steps = parse_integer("zoom: steps", value, kFewestZoomSteps, kMostZoomSteps);
  } else if (name == "frames") {
    plan.frames = parse_integer("zoom: frames", value, kFewestZoomFrames, kMostZoomFrames);
  } else if (name == "closer") {
    plan.closer = parse_real("zoom: closer", value, kLeastCloser, kMostCloser);
  } else if (name == "modes") {
    plan.modes = parse_zoom_modes(value);
  } else if (name == "size") {
    plan.size = value == "window" ? glm::ivec2(0) : parse_size("zoom: size", value);
  } else {
    fail(ErrorKind::usage, "zoom: '{}' is none of steps, frames, closer, modes and size", name);
  }
}

// The record with this folder in the list, or its end.
auto find_zoom(const std::vector<ZoomRecord>& records, const std::filesystem::path& folder) {
  return std::find_if(records.begin(), records.end(), [&](const ZoomRecord& record) {
    return !folder.empty() && record.folder == folder;
  });
}

std::filesystem::path full_path(const std::filesystem::path& path) {
  return std::filesystem::absolute(path).lexically_normal();
}

// The recording in the chart if it has files, else null with a message.
const ZoomRecord* saved_zoom(Viewer& v) {
  const ZoomRecord* record = shown_zoom(v.zoom);
  if (record != nullptr && !record->folder.empty()) return record;
  notify(v, "this zoom is not saved");
  return nullptr;
}

}  // namespace

void change_zoom_plan(Viewer& v, const ZoomPlan& plan) {
  v.zoom.plan = clamped_plan(plan, v.backend);
}

void choose_zoom(Viewer& v, const std::string& words) {
  ZoomPlan plan = v.zoom.plan;
  std::istringstream in(words);
  for (std::string word; in >> word;) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos)
      fail(ErrorKind::usage, "zoom: '{}' is not of the form steps=12", word);
    set_part(plan, word.substr(0, equals), word.substr(equals + 1));
  }
  change_zoom_plan(v, plan);
}

void start_zoom_here(Viewer& v) {
  ZoomPlan plan = v.zoom.plan;
  plan.start = v.camera;
  change_zoom_plan(v, plan);
}

void forget_zoom_start(Viewer& v) { v.zoom.plan.start.reset(); }

void show_zoom(Viewer& v, std::size_t index) {
  if (v.zoom.running || index >= v.zoom.records.size()) return;
  v.zoom.shown = index;
  if (v.zoom.beneath == index) v.zoom.beneath.reset();
}

void lay_zoom_beneath(Viewer& v, std::size_t index) {
  if (index >= v.zoom.records.size()) return;
  if (v.zoom.beneath == index) return v.zoom.beneath.reset();
  if (v.zoom.shown != index) v.zoom.beneath = index;
}

void show_zoom_quantity(Viewer& v, ZoomQuantity quantity) { v.zoom.quantity = quantity; }

void copy_zoom_figure(Viewer& v, Host& host) {
  const ZoomRecord* record = saved_zoom(v);
  if (record == nullptr) return;
  if (!record->has_figures)
    return notify(v, fmt::format("the figures are not drawn: gnuplot draws the files *.gp in {}",
                                 record->folder.string()));
  const ZoomQuantityRow& row = kZoomQuantities[static_cast<std::size_t>(v.zoom.quantity)];
  const std::string path = full_path(record->folder / row.figure).string();
  host.set_clipboard(path);
  notify(v, fmt::format("the path of the figure is on the clipboard: {}", path));
}

void open_zoom_folder(Viewer& v, Host& host) {
  const ZoomRecord* record = saved_zoom(v);
  if (record != nullptr) host.open_with_desktop(full_path(record->folder));
}

void zoom_job_ended(Viewer& v) { v.zoom.starting = false; }

void zoom_began(Viewer& v, const ZoomRecord& record) {
  // Only the last recording that was not saved stays.
  ZoomRecorder& zoom = v.zoom;
  if (!zoom.records.empty() && zoom.records.back().folder.empty()) {
    zoom.records.pop_back();
    if (zoom.beneath == zoom.records.size()) zoom.beneath.reset();
  }
  zoom.records.push_back(record);
  zoom.shown = zoom.records.size() - 1;
  zoom.running = true;
  zoom.starting = false;
}

void zoom_stepped(Viewer& v, const std::vector<BenchRow>& rows_of_step) {
  if (!v.zoom.running) return;
  std::vector<BenchRow>& rows = v.zoom.records.back().rows;
  rows.insert(rows.end(), rows_of_step.begin(), rows_of_step.end());
}

void zoom_ended(Viewer& v, const std::filesystem::path& folder, bool has_figures) {
  ZoomRecorder& zoom = v.zoom;
  if (zoom.running) {
    ZoomRecord& record = zoom.records.back();
    record.folder = folder;
    record.has_figures = has_figures;
    if (record.rows.empty()) {
      zoom.records.pop_back();
      zoom.shown.reset();
    }
  }
  zoom.running = false;
  picture_changed(v);  // the window still shows the recorder's last frame
}

void zoom_end_found(Viewer& v, double closer) {
  ZoomPlan plan = v.zoom.plan;
  plan.closer = closer;
  change_zoom_plan(v, plan);
  notify(v, fmt::format("the zoom ends {:.3g}x closer", v.zoom.plan.closer));
}

void zooms_found(Viewer& v, const std::vector<ZoomRecord>& records) {
  ZoomRecorder& zoom = v.zoom;
  std::vector<ZoomRecord> added;
  std::copy_if(records.begin(), records.end(), std::back_inserter(added),
               [&](const ZoomRecord& record) {
                 return find_zoom(zoom.records, record.folder) == zoom.records.end();
               });
  zoom.records.insert(zoom.records.begin(), added.begin(), added.end());
  if (zoom.shown) *zoom.shown += added.size();
  if (zoom.beneath) *zoom.beneath += added.size();
}

}  // namespace qs::action
