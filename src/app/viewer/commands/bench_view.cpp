// SPDX-License-Identifier: MIT
//
// Measures all modes as `bench` does and saves the report in bench/SCENE_NNNN.
#include <algorithm>
#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "app/measure/measure_view.h"
#include "app/measure/scene_facts.h"
#include "app/measure/statistics.h"
#include "app/report/bench_report.h"
#include "app/report/environment.h"
#include "app/session/alterations.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/mode_numbers.h"
#include "io/bytes/replace_file.h"

namespace qs::job {
namespace {

// Shows the progress between timed frames, four times a second: the next frame waits until the
// window was drawn and rests.
Progress bench_progress(RenderContext& context) {
  using Clock = std::chrono::steady_clock;
  const auto report = [&context, shown = Clock::time_point()](float fraction) mutable {
    constexpr std::chrono::milliseconds kPause{250}, kLongest{100}, kTurn{2};
    if (Clock::now() - shown < kPause) return;
    const int drawings = context.drawings;
    context.report(action::show_progress,
                   Loading{context.session.scene->path, kBenching, fraction});
    shown = Clock::now();
    while ((context.drawings == drawings || !context.window_rests) &&
           Clock::now() < shown + kLongest)
      std::this_thread::sleep_for(kTurn);
  };
  return {report, context.stop};
}

}  // namespace

void bench_view(RenderContext& context, const Viewer& viewer) {
  Session& session = context.session;
  const std::string name = scene_name(session.scene->path);
  check_folder(free_name(viewer.out_dir / "bench", name, ""));
  const auto settings = with_settings(session, full_frame(viewer).settings);
  const auto measuring = mark_measuring(context);
  BenchReport report;
  report.environment = environment_json(session);
  report.scenes.push_back(scene_facts(*session.scene, name));
  report.scenes.back()["gaussians"] = drawn_count(session);
  alterations_of(session).add_to(report.scenes.back());
  ViewPlan plan = session.backend == Backend::cpu ? ViewPlan{1, 1, 5} : ViewPlan{20, 4, 5};
  GpuClock clock = clock_of(session);
  plan.clock = &clock;
  const auto end = hide_progress_at_end(context);
  report.rows =
      measure_view(session, all_modes(), measured_camera(viewer), plan, bench_progress(context));
  add_clock(report.environment, clock);
  for (BenchRow& row : report.rows) {
    row.scene = name;
    row.camera = camera_name(viewer);
  }
  context.report(action::numbers_measured, ModeNumbers{viewer.view_version, report.rows, true});
  const auto noisy = std::ranges::count_if(report.rows, is_noisy);
  save_results(
      context, viewer, "bench", name,
      [&context, report](const std::filesystem::path& path) {
        const std::string problem = write_report(report, path);
        if (!problem.empty()) context.report(action::notify, problem);
      },
      noisy == 0 ? ": no row is noisy"
                 : fmt::format(": {} of {} rows are noisy: do not publish these", noisy,
                               report.rows.size()));
}

}  // namespace qs::job
