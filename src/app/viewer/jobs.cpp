// SPDX-License-Identifier: MIT
#include "app/viewer/jobs.h"

#include <system_error>

#include <fmt/format.h>

#include "app/bench/scene_facts.h"
#include "app/bench/write_report.h"
#include "app/bench/zoom_path.h"
#include "app/bench/zoom_recording.h"
#include "app/frame_metadata.h"
#include "app/inspect/construction.h"
#include "app/inspect/mapped_frame.h"
#include "app/shots.h"
#include "app/stats_file.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<Renderer> uploaded(Studio& studio, const Scene& scene, Backend backend) {
  auto renderer = make_renderer(backend, studio.options);
  renderer->upload(scene.cloud,
                   loading_progress(scene.path, "uploading", studio.stop, studio.report));
  return renderer;
}

// Steps and frames of a zoom that a person waits for.
struct ZoomPlan {
  int steps;
  ViewPlan plan;
};
ZoomPlan zoom_plan(Backend backend) {
  return backend == Backend::cpu ? ZoomPlan{12, {1, 1, 1}} : ZoomPlan{32, {20, 3, 1}};
}
ViewPlan bench_plan(Backend backend) {
  return backend == Backend::cpu ? ViewPlan{5, 1, 1} : ViewPlan{};
}

}  // namespace

Renderer& renderer_on(Studio& studio, Backend backend) {
  Session& session = studio.session;
  if (backend == session.backend) return *session.renderer;
  if (!studio.second) {
    const ReportAtEnd end(studio, action::SetLoading{});
    studio.second = uploaded(studio, session.scene, backend);
  }
  return *studio.second;
}

fs::path free_name(const fs::path& folder, const std::string& stem, const std::string& ending) {
  for (int n = 1;; ++n) {
    fs::path path = folder / fmt::format("{}_{:04}{}", stem, n, ending);
    std::error_code error;
    if (!fs::exists(path, error)) return path;
  }
}

Job open_scene(LoadedScene loaded, Backend backend, RenderSettings settings, bool keep_background) {
  return [loaded = std::move(loaded), backend, settings, keep_background](Studio& studio) mutable {
    const ReportAtEnd end(studio, action::SetLoading{});
    auto renderer = uploaded(studio, loaded.scene, backend);
    if (!keep_background)
      settings.background = glm::vec3(loaded.facts.white_background ? 1.0f : 0.0f);
    Session& session = studio.session;
    studio.second.reset();
    studio.reference.reset();
    session.renderer = std::move(renderer);
    session.scene = std::move(loaded.scene);
    session.backend = backend;
    session.device = studio.options.device;
    session.settings = settings;
    studio.report(action::SceneOpened{std::move(loaded.facts), settings, backend});
  };
}

Job switch_backend(Backend backend) {
  return [backend](Studio& studio) {
    const ReportAtEnd end(studio, action::SetLoading{});
    Session& session = studio.session;
    studio.second.reset();
    session.renderer = uploaded(studio, session.scene, backend);
    session.backend = backend;
    studio.report(action::BackendChanged{backend});
  };
}

Job pick_pivot(FrameOrder order, glm::ivec2 pixel) {
  return [order = std::move(order), pixel](Studio& studio) {
    const auto point = find_point(*studio.session.renderer, order.camera, order.settings, pixel);
    if (point) {
      studio.report(action::SetPivot{*point});
    } else {
      studio.report(action::Say{"nothing is under the cursor"});
    }
  };
}

Job take_screenshot(FrameOrder order, std::string camera_name, fs::path folder) {
  return [order = std::move(order), camera_name = std::move(camera_name),
          folder = std::move(folder)](Studio& studio) {
    Renderer& renderer = *studio.session.renderer;
    const Camera& camera = order.camera;
    std::optional<MappedFrame> mapped;
    if (order.heatmap)
      mapped.emplace(draw_mapped(renderer, camera, order.settings, *order.heatmap,
                                 studio.options.threads, studio.stop));
    const Frame& frame =
        mapped ? mapped->frame
               : renderer.render(camera, order.settings, {}, HostImage{}, studio.stop);
    const char* mode = mode_name(order.settings.mode);
    const fs::path scene = studio.session.scene.path;
    make_folder(folder / "screenshots");
    const fs::path name =
        with_word("picture", fmt::format("{}_{}_{}_{}x{}", scene_name(scene), camera_name, mode,
                                         camera.width, camera.height));
    const fs::path path =
        free_name(folder / "screenshots", name.string().substr(sizeof "picture"), ".png");
    const ImageMetadata metadata = frame_metadata(scene, camera, order.settings.mode, frame.stats);
    if (mapped) {
      const Heatmap& map = mapped->heatmap;
      write_image(draw_heatmap(frame.color, map, scale_for(map.values), mode), path, metadata);
    } else {
      write_image(frame.color, path, metadata);
    }
    studio.report(action::Say{fmt::format("wrote {}", path.string())});
  };
}

Job record_zoom_from(FrameOrder order, glm::ivec2 pixel, fs::path folder) {
  return [order = std::move(order), pixel, folder = std::move(folder)](Studio& studio) {
    Session& session = studio.session;
    const WithSettings settings(session, order.settings);
    const auto target = find_point(*session.renderer, order.camera, order.settings, pixel);
    if (!target) {
      studio.report(action::ZoomEnded{});
      return studio.report(action::Say{"nothing is in the middle of the picture to zoom to", true});
    }
    const ZoomPlan plan = zoom_plan(session.backend);
    ZoomBundle bundle = start_zoom(session, order.camera, *target);
    bundle.steps = plan.steps;
    studio.report(action::ZoomStepped{bundle.steps, {}});
    FrameOrder shown = order;
    const auto on_step = [&](const Camera& camera, const std::vector<BenchRow>& rows) {
      studio.report(action::ZoomStepped{bundle.steps, rows});
      shown.camera = camera;
      studio.show(shown);
    };
    try {
      bundle.rows = record_zoom(session, bundle, plan.plan, {{}, studio.stop}, on_step);
      const fs::path path = free_name(folder / "zoom", scene_name(session.scene.path), "");
      const std::string problem = save_zoom(session, bundle, path);
      if (!problem.empty()) studio.report(action::Say{problem});
      studio.report(action::ZoomEnded{path});
      studio.report(action::Say{fmt::format("wrote {}", path.string())});
    } catch (...) {
      studio.report(action::ZoomEnded{});
      studio.report(action::Say{"the zoom was stopped, nothing was saved"});
      throw;
    }
  };
}

Job bench_view(FrameOrder order, std::string camera_name, fs::path folder) {
  return [order = std::move(order), camera_name = std::move(camera_name),
          folder = std::move(folder)](Studio& studio) {
    Session& session = studio.session;
    const WithSettings settings(session, order.settings);
    studio.report(action::MeasuringChanged{true});
    const ReportAtEnd end(studio, action::MeasuringChanged{false});
    BenchReport report;
    report.environment = environment_json(session);
    const std::string name = scene_name(session.scene.path);
    report.scenes.push_back(scene_facts(session.scene, name));
    report.rows = measure_view(session, all_modes(), order.camera, bench_plan(session.backend),
                               {{}, studio.stop});
    for (BenchRow& row : report.rows) {
      row.scene = name;
      row.camera = camera_name;
    }
    const fs::path path = free_name(folder / "bench", name, "");
    const std::string problem = write_report(report, path);
    if (!problem.empty()) studio.report(action::Say{problem});
    studio.report(action::NumbersMeasured{{order.view_version, report.rows}});
    studio.report(action::Say{fmt::format("wrote {}", path.string())});
  };
}

Job inspect_view(FrameOrder order, glm::ivec2 pixel, std::optional<std::uint32_t> gaussian) {
  return [order = std::move(order), pixel, gaussian](Studio& studio) {
    const Frame& frame = studio.session.renderer->render(
        order.camera, order.settings, inspection_outputs(), HostImage{}, studio.stop);
    const glm::ivec2 size(order.camera.width, order.camera.height);
    InspectedView view{
        order.version, inspect(frame, size, pixel, order.settings.background, gaussian), {}};
    if (view.inspection.gaussian) {
      view.construction = draw_construction(
          {view.inspection, frame.color, frame.grid, scene_name(studio.session.scene.path)});
    }
    studio.report(action::PixelInspected{std::move(view)});
  };
}

Job ask_oracle_about(FrameOrder order, std::optional<PixelBox> region) {
  return [order = std::move(order), region](Studio& studio) {
    constexpr int kTolerance = 2;  // of 8-bit values
    const ReportAtEnd end(studio, action::SetLoading{});
    Outputs outputs;
    outputs.trace = true;
    const Frame frame = studio.session.renderer->render(order.camera, order.settings, outputs,
                                                        HostImage{}, studio.stop);
    Renderer& cpu = renderer_on(studio, Backend::cpu);
    const Progress progress = loading_progress(
        studio.session.scene.path, "computing the reference of", studio.stop, studio.report);
    progress.update(0);
    Image truth = reference_of(cpu, order.camera, order.settings, region, progress);
    const Verdict verdict =
        judge(cpu, order.camera, order.settings, frame, truth, region, kTolerance, progress);
    studio.reference = ReferenceImage{order.view_version, verdict.region, std::move(truth)};
    studio.report(action::OracleAnswered{{order.version, verdict,
                                          fmt::format("{}: {}", mode_name(order.settings.mode),
                                                      verdict_sentence(verdict, kTolerance))}});
    if (order.other) studio.show(order);
  };
}

}  // namespace qs
