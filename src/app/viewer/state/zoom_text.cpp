// SPDX-License-Identifier: MIT
#include "app/viewer/state/zoom_text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/measure/noise.h"
#include "app/viewer/state/charts.h"
#include "app/viewer/state/mode_numbers.h"

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
  ordered_json modes = ordered_json::array();
  for (const CullMode mode : zoom_modes(plan)) modes.push_back(mode_name(mode));
  const Camera start = zoom_start(plan, viewer.camera);
  return {{"start", plan.start ? "remembered" : "this view"},
          {"closer", plan.closer},
          {"steps", plan.steps},
          {"frames", plan.frames},
          {"modes", modes},
          {"size", {start.width, start.height}},
          {"text", zoom_plan_text(viewer)}};
}

ordered_json ticks_json(const std::vector<AxisTick>& ticks) {
  ordered_json list = ordered_json::array();
  for (const AxisTick& tick : ticks) list.push_back(tick.text);
  return list;
}

ordered_json chart_json(const ZoomRecorder& zoom) {
  const ZoomChart chart = zoom_chart(shown_zoom(zoom), zoom_beneath(zoom), zoom.quantity);
  ordered_json curves = ordered_json::array();
  for (const ZoomCurve& curve : chart.curves) {
    ordered_json points = ordered_json::array();
    for (const ZoomPoint& point : curve.points) points.push_back({point.zoom, point.value});
    curves.push_back({{"mode", mode_name(curve.mode)},
                      {"dashed", curve.is_beneath},
                      {"band", curve.is_banded},
                      {"points", points}});
  }
  return {{"title", chart.title},
          {"zoom_ticks", ticks_json(chart.zoom_ticks)},
          {"value_ticks", ticks_json(chart.value_ticks)},
          {"curves", curves}};
}

}  // namespace

std::optional<double> zoom_seconds(const Viewer& viewer) {
  const ZoomPlan& plan = viewer.zoom.plan;
  if (viewer.camera.width < 1) return std::nullopt;
  const Camera start = zoom_start(plan, viewer.camera);
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
  return fmt::format("{} \u00b7 {} \u00b7 {} x {} \u00b7 {}", zoom_title(record), record.pipeline,
                     record.width, record.height, record.machine);
}

std::string zoom_trust_text(const ZoomRecord& record) {
  const std::uint64_t frames = frames_per_point(record.rows);
  std::string text;
  if (frames == 1) text = "single frames";
  if (frames > 1) text = fmt::format("medians of {} frames", frames);
  if (has_bands(record.rows)) text += ", band: 5-95 % of them";
  const std::string noisy = noisy_steps(record.rows);
  if (!noisy.empty()) text += fmt::format("{}noisy steps: {}", text.empty() ? "" : "; ", noisy);
  return text;
}

ordered_json zoom_json(const Viewer& viewer) {
  const ZoomRecorder& zoom = viewer.zoom;
  const ZoomRecord* record = shown_zoom(zoom);
  ordered_json labels = ordered_json::array();
  for (const ZoomRecord& each : zoom.records) labels.push_back(zoom_label(each));
  return {{"running", zoom.running},
          {"rows", record == nullptr ? 0 : record->rows.size()},
          {"frames", record == nullptr ? 0 : frames_per_point(record->rows)},
          {"folder", record == nullptr ? "" : record->folder.string()},
          {"status", zoom_status(zoom)},
          {"trust", record == nullptr ? "" : zoom_trust_text(*record)},
          {"plan", plan_json(viewer)},
          {"recordings", labels},
          {"chart", chart_json(zoom)}};
}

}  // namespace qs
