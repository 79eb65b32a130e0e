// SPDX-License-Identifier: MIT
//
// Measures all modes as `bench` does and saves the report in bench/SCENE_NNNN.
#include <fmt/format.h>

#include "app/measure/measure_view.h"
#include "app/measure/scene_facts.h"
#include "app/report/bench_report.h"
#include "app/report/environment.h"
#include "app/session/alterations.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/mode_numbers.h"

namespace qs::job {

void bench_view(RenderContext& context, const Viewer& viewer) {
  Session& session = context.session;
  const auto settings = with_settings(session, full_frame(viewer).settings);
  const auto measuring = mark_measuring(context);
  BenchReport report;
  report.environment = environment_json(session);
  const std::string name = scene_name(session.scene->path);
  report.scenes.push_back(scene_facts(*session.scene, name));
  alterations_of(session).add_to(report.scenes.back());
  ViewPlan plan = session.backend == Backend::cpu ? ViewPlan{1, 1, 5} : ViewPlan{20, 4, 5};
  GpuClock clock = clock_of(session);
  plan.clock = &clock;
  report.rows =
      measure_view(session, all_modes(), measured_camera(viewer), plan, {{}, context.stop});
  add_clock(report.environment, clock);
  for (BenchRow& row : report.rows) {
    row.scene = name;
    row.camera = camera_name(viewer);
  }
  const std::filesystem::path path = free_name(viewer.out_dir / "bench", name, "");
  const std::string problem = write_report(report, path);
  if (!problem.empty()) context.report(action::notify, problem);
  context.report(action::numbers_measured, ModeNumbers{viewer.view_version, report.rows, true});
  context.report(action::notify_file, path, std::string());
}

}  // namespace qs::job
