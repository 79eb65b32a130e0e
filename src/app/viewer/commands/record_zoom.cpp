// SPDX-License-Identifier: MIT
//
// The jobs of the zoom recorder: it measures the modes of the plan from its start to the point in
// the middle of the start's picture, shows every step and saves the recording in zoom/SCENE_NNNN.
// A program that sends its files keeps the numbers only. And the search for the zooms of earlier
// sessions in the folder zoom of Viewer::out_dir.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "app/measure/camera_path.h"
#include "app/measure/scene_facts.h"
#include "app/report/environment.h"
#include "app/report/zoom_bundle.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/commands/zoom_figure.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/training_actions.h"
#include "app/viewer/state/zoom_actions.h"
#include "base/error.h"
#include "base/path_kind.h"
#include "io/bytes/replace_file.h"

namespace qs {
namespace {

RenderSettings zoom_settings(const Viewer& viewer) {
  RenderSettings settings = full_frame(viewer).settings;
  settings.pipeline = viewer.zoom.plan.pipeline.value_or(settings.pipeline);
  return settings;
}

// The point that the start of the plan approaches. Empty, with a message, if the middle of its
// picture is empty.
std::optional<glm::dvec3> zoom_target(RenderContext& context, const Viewer& viewer) {
  const Camera start = zoom_start(viewer.zoom.plan, measured_camera(viewer));
  const auto target =
      find_point(*context.session.renderer, start, zoom_settings(viewer), center_pixel(start));
  if (!target)
    context.report(action::notify_error,
                   "there is nothing to zoom to in the middle of the picture");
  return target;
}

ZoomBundle planned_zoom(const Session& session, const Viewer& viewer, glm::dvec3 target) {
  const ZoomPlan& plan = viewer.zoom.plan;
  ZoomBundle bundle = start_zoom(session, zoom_start(plan, measured_camera(viewer)), target);
  bundle.steps = plan.steps;
  bundle.closest = 1 / plan.closer;
  bundle.modes = zoom_modes(plan);
  return bundle;
}

// Shows the step in the window, in the window's size and settings.
void show_step(RenderContext& context, const Viewer& viewer, const ZoomBundle& bundle, int step) {
  FrameRequest request = full_frame(viewer);
  request.camera = zoom_camera(bundle.start, bundle.target, bundle.steps, bundle.closest, step)
                       .resized(viewer.camera.width, viewer.camera.height);
  context.show(request);
}

// Adds every step to the bundle, measured while the window rests; between the steps the window
// shows the new points. Throws Cancelled if the zoom is stopped.
void measure_steps(RenderContext& context, const Viewer& viewer, ZoomBundle& bundle,
                   GpuClock& clock) {
  ViewPlan plan{viewer.zoom.plan.frames, kZoomWarmUp, 1};
  plan.clock = &clock;
  const auto measuring = mark_measuring(context);
  for (int step = 0; step < bundle.steps; ++step) {
    show_step(context, viewer, bundle, step);
    const std::vector<BenchRow> measured = undisturbed(context, [&](const Progress& progress) {
      return measure_zoom_step(context.session, bundle, static_cast<std::size_t>(step), plan,
                               progress);
    });
    context.report(action::zoom_stepped, measured);
    bundle.rows.insert(bundle.rows.end(), measured.begin(), measured.end());
  }
}

// Makes a stopped zoom a whole one that ends at its last step. False if it has less than two steps.
bool end_at_last_step(ZoomBundle& bundle) {
  const int done = static_cast<int>(bundle.rows.size() / bundle.modes.size());
  if (done < kFewestZoomSteps) return false;
  bundle.closest = std::pow(bundle.closest, (done - 1.0) / (bundle.steps - 1));
  bundle.steps = done;
  return true;
}

// Saves the zoom. If it cannot be written, it stays in memory.
void save(RenderContext& context, const Viewer& viewer, const ZoomBundle& bundle) {
  save_results(context, viewer, "zoom", scene_name(bundle.scene),
               [&context, bundle](const std::filesystem::path& path) {
                 const std::string problem = save_zoom(context.session, bundle, path);
                 if (!problem.empty()) {
                   write_zoom_figures(bundle, path);
                   context.report(action::notify, problem + ", or use the window's own figures");
                 }
                 context.report(action::zoom_ended, path, true);
               });
}

void record(RenderContext& context, const Viewer& viewer) {
  Session& session = context.session;
  const AtEnd ended{[&context] { context.report(action::zoom_job_ended); }};
  if (!viewer.is_remote) check_folder(free_name(viewer.out_dir / "zoom", "new", ""));
  const auto settings = with_settings(session, zoom_settings(viewer));
  const std::optional<glm::dvec3> target = zoom_target(context, viewer);
  if (!target) return;
  ZoomBundle bundle = planned_zoom(session, viewer, *target);
  context.report(action::zoom_began, make_zoom_record(bundle));
  const AtEnd over{
      [&context] { context.report(action::zoom_ended, std::filesystem::path(), false); }};
  GpuClock clock = clock_of(session);
  try {
    measure_steps(context, viewer, bundle, clock);
  } catch (const Cancelled&) {
    const int planned = bundle.steps;
    const bool saves = !viewer.is_remote && context.keeps_part && end_at_last_step(bundle);
    context.report(action::notify,
                   fmt::format("the zoom was stopped{}",
                               saves ? fmt::format(" after {} of {} steps", bundle.steps, planned)
                                     : ", nothing was saved"));
    if (!saves) throw;
  }
  add_clock(bundle.environment, clock);
  if (!viewer.is_remote) save(context, viewer, bundle);
}

void find_end(RenderContext& context, const Viewer& viewer) {
  const std::optional<glm::dvec3> target = zoom_target(context, viewer);
  if (!target) return;
  const Camera start = zoom_start(viewer.zoom.plan, measured_camera(viewer));
  const double closer =
      glm::distance(start.position(), *target) / glm::distance(viewer.camera.position(), *target);
  if (!(closer >= kLeastCloser))
    return context.report(action::notify_error,
                          "this view is not nearer to the target of the zoom than its start");
  context.report(action::zoom_end_found, closer);
}

constexpr std::ptrdiff_t kMostFound = 50;                            ///< the newest
constexpr std::uintmax_t kMostZoomBytes = std::uintmax_t{16} << 20;  ///< of a zoom.json

// The files zoom.json below `folder`, oldest first.
std::vector<std::filesystem::path> zoom_files(const std::filesystem::path& folder) {
  std::vector<std::pair<std::filesystem::file_time_type, std::filesystem::path>> found;
  std::error_code error;
  for (std::filesystem::directory_iterator each(folder, error), end; !error && each != end;
       each.increment(error)) {
    const std::filesystem::path path = each->path() / "zoom.json";
    std::error_code unreadable;
    const std::uintmax_t bytes = std::filesystem::file_size(path, unreadable);
    const auto time = std::filesystem::last_write_time(path, unreadable);
    if (!unreadable && bytes <= kMostZoomBytes) found.emplace_back(time, path);
  }
  std::ranges::sort(found);
  std::vector<std::filesystem::path> paths;
  for (const auto& [time, path] : found) paths.push_back(path);
  if (std::ssize(paths) > kMostFound) paths.erase(paths.begin(), paths.end() - kMostFound);
  return paths;
}

void list_zooms(RenderContext& context, const Viewer& viewer) {
  std::vector<ZoomRecord> records;
  for (const std::filesystem::path& path : zoom_files(viewer.out_dir / "zoom")) {
    try {
      ZoomRecord record = make_zoom_record(read_zoom_json(path));
      record.folder = path.parent_path();
      record.has_figures = is_there(record.folder / kZoomQuantities[0].figure);
      if (!record.rows.empty()) records.push_back(std::move(record));
    } catch (const Error&) {  // another program's file, or a damaged one
    }
  }
  context.report(action::zooms_found, std::move(records));
}

}  // namespace

void action::toggle_zoom_recording(Viewer& viewer, Host& host) {
  if (viewer.zoom.running) return host.leave_job(true);
  if (!viewer.scene || viewer.zoom.starting) return;
  if (is_training(viewer))
    return notify_error(viewer, "a zoom is recorded once training is paused or over");
  // Opening the panel would change the size of the picture that is recorded.
  if (!viewer.panels.recorder || !viewer.panels.all)
    notify(viewer, "recording a zoom: the panel of Z shows it, Shift+Z stops it");
  viewer.zoom.plan = clamped_plan(viewer.zoom.plan, viewer.backend);
  viewer.playback.running = false;
  viewer.zoom.starting = true;
  start_long_job(viewer, host, record);
}

void action::end_zoom_here(Viewer& viewer, Host& host) {
  if (!viewer.scene || viewer.zoom.running) return;
  if (!viewer.zoom.plan.start)
    return notify(viewer, "choose the start of the zoom first, at another view");
  start_job(viewer, host, find_end);
}

void action::find_zooms(Viewer& viewer, Host& host) {
  if (viewer.zoom.searched) return;
  viewer.zoom.searched = true;
  start_job(viewer, host, list_zooms);
}

}  // namespace qs
