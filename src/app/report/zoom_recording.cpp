// SPDX-License-Identifier: MIT
#include "app/report/zoom_recording.h"

#include <fmt/format.h>

#include "app/measure/scene_facts.h"
#include "app/measure/zoom_path.h"
#include "app/report/stats_file.h"
#include "app/report/zoom_plots.h"
#include "base/progress_bar.h"
#include "io/bytes/replace_file.h"
#include "io/bytes/text_file.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

// Writes the first, middle and last step in the default mode.
void save_pictures(Session& session, const ZoomBundle& bundle,
                   const std::filesystem::path& folder) {
  const std::vector<Camera> path =
      zoom_path(bundle.start, bundle.target, bundle.steps, bundle.closest);
  RenderSettings settings = session.settings;
  settings.mode = default_mode();
  for (const std::size_t step : {std::size_t{0}, path.size() / 2, path.size() - 1}) {
    write_image(session.renderer->render(path[step], settings).color,
                folder / fmt::format("step_{:04}.png", step));
  }
}

}  // namespace

ZoomBundle start_zoom(const Session& session, const Camera& start, glm::dvec3 target) {
  ZoomBundle bundle;
  bundle.scene = std::filesystem::absolute(session.scene->path);
  bundle.scene_hash = file_hash(session.scene->path);
  bundle.start = start;
  bundle.target = target;
  bundle.settings = session.settings;
  bundle.environment = environment_json(session);
  bundle.modes = all_modes();
  return bundle;
}

std::vector<BenchRow> measure_zoom_step(Session& session, const ZoomBundle& bundle,
                                        std::size_t step, const ViewPlan& plan,
                                        const Progress& progress) {
  const Camera camera = zoom_camera(bundle.start, bundle.target, bundle.steps, bundle.closest,
                                    static_cast<int>(step));
  ViewPlan turned = plan;
  turned.first_round = step;
  std::vector<BenchRow> rows = measure_view(session, bundle.modes, camera, turned, progress);
  for (BenchRow& row : rows) {
    row.scene = scene_name(session.scene->path);
    row.camera = fmt::format("{}", step);
    row.view = step;
  }
  return rows;
}

std::vector<BenchRow> record_zoom(Session& session, const ZoomBundle& bundle, const ViewPlan& plan,
                                  const Progress& progress) {
  std::vector<BenchRow> rows;
  const auto steps = static_cast<std::size_t>(bundle.steps);
  for (std::size_t step = 0; step < steps; ++step) {
    const Progress part = step_of(progress, step, steps);
    part.update(0);
    const std::vector<BenchRow> measured = measure_zoom_step(session, bundle, step, plan, part);
    rows.insert(rows.end(), measured.begin(), measured.end());
  }
  return rows;
}

std::string save_zoom(Session& session, const ZoomBundle& bundle,
                      const std::filesystem::path& folder) {
  std::string problem;
  replace_folder(folder, [&](const std::filesystem::path& hidden) {
    write_text(hidden / "zoom.csv", format_csv(bundle.rows));
    write_text(hidden / "zoom.json", format_zoom_json(bundle));
    save_pictures(session, bundle, hidden);
    problem = draw_plots(hidden, zoom_plots(bundle), folder);
  });
  return problem;
}

}  // namespace qs
