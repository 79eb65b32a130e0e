// SPDX-License-Identifier: MIT
//
// The zoom recorder: measures all modes from this view to the point in its middle, shows every step
// and saves the recording in zoom/SCENE_NNNN.
#include <fmt/format.h>

#include "app/measure/scene_facts.h"
#include "app/measure/zoom_path.h"
#include "app/report/clock_report.h"
#include "app/report/zoom_recording.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/commands/output_names.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"

namespace qs {
namespace {

// Few enough steps and frames for a user to wait for.
struct ZoomPlan {
  int steps;
  ViewPlan plan;
};
ZoomPlan zoom_plan(Backend backend) {
  return backend == Backend::cpu ? ZoomPlan{12, {1, 1, 1}} : ZoomPlan{32, {20, 3, 1}};
}

void record(RenderContext& context, const Viewer& viewer) {
  Session& session = context.session;
  FrameRequest request = full_frame(viewer);
  const auto settings = with_settings(session, request.settings);
  const auto target =
      find_point(*session.renderer, request.camera, request.settings, center_pixel(request.camera));
  if (!target) {
    context.report(action::zoom_ended, "");
    return context.report(action::notify_error,
                          "there is nothing to zoom to in the middle of the picture");
  }
  ZoomPlan plan = zoom_plan(session.backend);
  GpuClock clock = clock_of(session);
  plan.plan.clock = &clock;
  ZoomBundle bundle = start_zoom(session, request.camera, *target);
  bundle.steps = plan.steps;
  const auto on_step = [&](const Camera& camera, const std::vector<BenchRow>& rows) {
    context.report(action::zoom_stepped, bundle.steps, rows);
    request.camera = camera;
    context.show(request);
  };
  context.report(action::zoom_stepped, bundle.steps, std::vector<BenchRow>());
  try {
    bundle.rows = record_zoom(session, bundle, plan.plan, {{}, context.stop}, on_step);
    add_clock(bundle.environment, clock);
    const std::filesystem::path path =
        free_name(viewer.out_dir / "zoom", scene_name(session.scene->path), "");
    const std::string problem = save_zoom(session, bundle, path);
    if (!problem.empty()) context.report(action::notify, problem);
    context.report(action::zoom_ended, path);
    context.report(action::notify, fmt::format("wrote {}", path.string()));
  } catch (...) {
    context.report(action::zoom_ended, "");
    context.report(action::notify, "the zoom was stopped, nothing was saved");
    throw;
  }
}

}  // namespace

void action::toggle_zoom_recorder(Viewer& viewer, Host& host) {
  if (viewer.zoom.running) return host.stop_job();
  if (!viewer.scene) return;
  viewer.panels.recorder = true;
  start_job(viewer, host, record);
}

}  // namespace qs
