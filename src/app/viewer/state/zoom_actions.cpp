// SPDX-License-Identifier: MIT
#include "app/viewer/state/zoom_actions.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

#include <fmt/format.h>

#include "app/measure/statistics.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/charts.h"
#include "app/viewer/state/mode_numbers.h"
#include "base/fail.h"
#include "base/list_of.h"
#include "base/text.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

// Milliseconds of a frame per pixel; 0 if no time is known.
double ms_per_pixel(const Viewer& viewer, CullMode mode, Pipeline pipeline) {
  const BenchRow* row = measured_row(viewer, mode, pipeline);
  if (row != nullptr && row->ms_median > 0 && row->width > 0 && row->height > 0)
    return row->ms_median / (static_cast<double>(row->width) * row->height);
  const ShownFrame& shown = viewer.shown;
  const double pixels = static_cast<double>(shown.camera.width) * shown.camera.height /
                        (static_cast<double>(shown.divisor) * shown.divisor);
  return pixels > 0 ? static_cast<double>(shown.stats.frame_ms) / pixels : 0;
}

std::size_t steps_done(const ZoomRecord& record) {
  return record.modes.empty() ? 0 : record.rows.size() / record.modes.size();
}

ordered_json plan_json(const Viewer& viewer) {
  const ZoomPlan& plan = viewer.zoom.plan;
  const Camera start = zoom_start(plan, measured_camera(viewer));
  return {{"start", plan.start ? "remembered" : "this view"},
          {"closer", plan.closer},
          {"steps", plan.steps},
          {"frames", plan.frames},
          {"modes", list_of<ordered_json>(zoom_modes(plan), mode_name)},
          {"size", {start.width, start.height}},
          {"text", zoom_plan_text(viewer)}};
}

ordered_json chart_json(const ZoomRecorder& zoom) {
  const ZoomChart chart = zoom_chart(shown_zoom(zoom), zoom_beneath(zoom), zoom.quantity);
  const auto point_json = [](const ZoomPoint& point) {
    return ordered_json{point.zoom, point.value};
  };
  const auto curve_json = [&](const ZoomCurve& curve) {
    return ordered_json{{"mode", mode_name(curve.mode)},
                        {"dashed", curve.is_beneath},
                        {"bars", curve.has_bars},
                        {"points", list_of<ordered_json>(curve.points, point_json)}};
  };
  return {{"title", chart.title},
          {"zoom_ticks", list_of<ordered_json>(chart.zoom_ticks, &AxisTick::text)},
          {"value_ticks", list_of<ordered_json>(chart.value_ticks, &AxisTick::text)},
          {"curves", list_of<ordered_json>(chart.curves, curve_json)}};
}

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

bool is_listed(const std::vector<ZoomRecord>& records, const std::filesystem::path& folder) {
  return !folder.empty() && std::ranges::count(records, folder, &ZoomRecord::folder) > 0;
}

std::filesystem::path full_path(const std::filesystem::path& path) {
  return std::filesystem::absolute(path).lexically_normal();
}

// The recording in the chart if it has files, else null with a message.
const ZoomRecord* saved_zoom(Viewer& v) {
  const ZoomRecord* record = shown_zoom(v.zoom);
  if (record != nullptr && !record->folder.empty()) return record;
  action::notify(v, "this zoom is not saved");
  return nullptr;
}

}  // namespace

std::optional<double> zoom_seconds(const Viewer& viewer) {
  const ZoomPlan& plan = viewer.zoom.plan;
  if (viewer.camera.width < 1) return std::nullopt;
  const Camera start = zoom_start(plan, measured_camera(viewer));
  const double pixels = static_cast<double>(start.width) * start.height;
  double ms = 0;
  for (const CullMode mode : zoom_modes(plan)) {
    const double each =
        ms_per_pixel(viewer, mode, plan.pipeline.value_or(viewer.settings.pipeline));
    if (!(each > 0)) return std::nullopt;
    ms += each * pixels;
  }
  return plan.steps * zoom_frames(plan, viewer.backend) * ms / 1000;
}

std::optional<double> zoom_seconds_left(const ZoomRecorder& zoom) {
  if (!zoom.running || zoom.records.empty()) return std::nullopt;
  const ZoomRecord& record = zoom.records.back();
  const auto done = static_cast<double>(steps_done(record));
  if (done < 1) return std::nullopt;
  double ms = 0;
  for (const BenchRow& row : record.rows) ms += row.ms_mean > 0 ? row.ms_mean : row.ms_median;
  const double frames = static_cast<double>(frames_per_point(record.rows)) + kZoomWarmUp;
  return (record.steps - done) * frames * ms / done / 1000;
}

std::string about_text(double seconds) {
  if (seconds < 1) return "less than 1 s";
  if (seconds <= 10) return fmt::format("about {:.0f} s", std::ceil(seconds));
  if (seconds <= 55) return fmt::format("about {:.0f} s", 5 * std::ceil(seconds / 5));
  if (seconds <= 3540) return fmt::format("about {:.0f} min", std::ceil(seconds / 60));
  return fmt::format("about {:.0f} h", std::ceil(seconds / 3600));
}

const char* zoom_start_text(const ZoomPlan& plan) {
  return plan.start ? "from a remembered view" : "from this view";
}

std::string zoom_plan_text(const Viewer& viewer) {
  const ZoomPlan& plan = viewer.zoom.plan;
  const std::size_t modes = zoom_modes(plan).size();
  const std::optional<double> seconds = zoom_seconds(viewer);
  return fmt::format("{} steps of {} mode{}: {}", plan.steps, modes, modes == 1 ? "" : "s",
                     seconds ? about_text(*seconds) : "time not known yet");
}

std::string running_text(const Viewer& viewer) {
  constexpr float kKnown = 0.05f;  // of the work, before its time is estimated
  if (viewer.zoom.running && !viewer.zoom.records.empty())
    return "recording a zoom, " + zoom_status(viewer.zoom);
  if (!viewer.loading) return "";
  const Loading& loading = *viewer.loading;
  const double left =
      (viewer.now - loading.began) * (1 / static_cast<double>(loading.fraction) - 1);
  return fmt::format("{}, {:.0f} %{}", loading.what, 100 * loading.fraction,
                     loading.fraction > kKnown ? fmt::format(", {} left", about_text(left)) : "");
}

std::string zoom_status(const ZoomRecorder& zoom) {
  if (zoom.running) {
    const ZoomRecord& record = zoom.records.back();
    const std::optional<double> left = zoom_seconds_left(zoom);
    return fmt::format("step {} of {}{}", steps_done(record), record.steps,
                       left ? fmt::format(", {} left", about_text(*left)) : "");
  }
  const ZoomRecord* record = shown_zoom(zoom);
  if (record == nullptr) return "";
  if (record->folder.empty() && steps_done(*record) == static_cast<std::size_t>(record->steps))
    return fmt::format("all {} steps, not saved", record->steps);
  if (record->folder.empty())
    return fmt::format("stopped after {} of {} steps, not saved", steps_done(*record),
                       record->steps);
  return fmt::format("saved in {}", record->folder.string());
}

std::string zoom_title(const ZoomRecord& record) {
  return record.folder.empty() ? record.scene + ", not saved" : record.folder.filename().string();
}

std::string zoom_label(const ZoomRecord& record) {
  const std::string altered = alterations_in(record.rows);
  return fmt::format("{} \u00b7 {} \u00b7 {} x {} \u00b7 {}{}", zoom_title(record), record.pipeline,
                     record.width, record.height, record.machine,
                     altered.empty() ? "" : " \u00b7 " + altered);
}

std::string zoom_trust_text(const ZoomRecord& record) {
  const std::uint64_t frames = frames_per_point(record.rows);
  std::string text;
  if (frames == 1) text = "single frames";
  if (frames > 1) text = fmt::format("medians of {} frames", frames);
  if (has_bars(record.rows)) text += ", bars: the middle half of them";
  const std::string noisy = noisy_steps(record.rows);
  if (!noisy.empty())
    text += fmt::format("{}noisy steps (rings): {}", text.empty() ? "" : "; ", noisy);
  return text;
}

ordered_json zoom_json(const Viewer& viewer) {
  const ZoomRecorder& zoom = viewer.zoom;
  const ZoomRecord* record = shown_zoom(zoom);
  return {{"running", zoom.running},
          {"rows", record == nullptr ? 0 : record->rows.size()},
          {"frames", record == nullptr ? 0 : frames_per_point(record->rows)},
          {"folder", record == nullptr ? "" : record->folder.string()},
          {"status", zoom_status(zoom)},
          {"trust", record == nullptr ? "" : zoom_trust_text(*record)},
          {"plan", plan_json(viewer)},
          {"recordings", list_of<ordered_json>(zoom.records, zoom_label)},
          {"chart", chart_json(zoom)}};
}

void action::change_zoom_plan(Viewer& v, const ZoomPlan& plan) {
  v.zoom.plan = clamped_plan(plan, v.backend);
}

void action::choose_zoom(Viewer& v, const std::string& words) {
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

void action::start_zoom_here(Viewer& v) { v.zoom.plan.start = v.camera; }

void action::forget_zoom_start(Viewer& v) { v.zoom.plan.start.reset(); }

void action::show_zoom(Viewer& v, std::size_t index) {
  if (v.zoom.running || index >= v.zoom.records.size()) return;
  v.zoom.shown = index;
  if (v.zoom.beneath == index) v.zoom.beneath.reset();
}

void action::lay_zoom_beneath(Viewer& v, std::size_t index) {
  if (index >= v.zoom.records.size()) return;
  if (v.zoom.beneath == index) return v.zoom.beneath.reset();
  if (v.zoom.shown != index) v.zoom.beneath = index;
}

void action::show_zoom_quantity(Viewer& v, ZoomQuantity quantity) { v.zoom.quantity = quantity; }

void action::copy_zoom_figure(Viewer& v, Host& host) {
  const ZoomRecord* record = saved_zoom(v);
  if (record == nullptr) return;
  if (!record->has_figures)
    return notify(v, fmt::format("the figures are not drawn: gnuplot draws the files *.gp in {}",
                                 record->folder.string()));
  const ZoomQuantityRow& row = kZoomQuantities[static_cast<std::size_t>(v.zoom.quantity)];
  const std::string path = full_path(record->folder / row.figure).string();
  if (host.copy_picture(path)) return notify(v, "the figure is on the clipboard");
  host.set_clipboard(path);
  notify(v,
         fmt::format("the path of the figure is on the clipboard, because pictures need xclip or "
                     "wl-copy: {}",
                     path));
}

void action::open_zoom_folder(Viewer& v, Host& host) {
  const ZoomRecord* record = saved_zoom(v);
  if (record != nullptr) host.open_with_desktop(full_path(record->folder));
}

void action::zoom_job_ended(Viewer& v) { v.zoom.starting = false; }

void action::zoom_began(Viewer& v, const ZoomRecord& record) {
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

void action::zoom_stepped(Viewer& v, const std::vector<BenchRow>& rows_of_step) {
  if (!v.zoom.running) return;
  std::vector<BenchRow>& rows = v.zoom.records.back().rows;
  rows.insert(rows.end(), rows_of_step.begin(), rows_of_step.end());
}

void action::zoom_ended(Viewer& v, const std::filesystem::path& folder, bool has_figures) {
  ZoomRecorder& zoom = v.zoom;
  if (!zoom.records.empty() && zoom.records.back().folder.empty()) {
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

void action::zoom_end_found(Viewer& v, double closer) {
  v.zoom.plan.closer = closer;
  v.zoom.plan = clamped_plan(v.zoom.plan, v.backend);
  notify(v, fmt::format("the zoom ends {:.3g}x closer", v.zoom.plan.closer));
}

void action::zooms_found(Viewer& v, const std::vector<ZoomRecord>& records) {
  ZoomRecorder& zoom = v.zoom;
  std::vector<ZoomRecord> added = records;
  std::erase_if(added, [&](const auto& record) { return is_listed(zoom.records, record.folder); });
  zoom.records.insert(zoom.records.begin(), added.begin(), added.end());
  if (zoom.shown) *zoom.shown += added.size();
  if (zoom.beneath) *zoom.beneath += added.size();
}

}  // namespace qs
