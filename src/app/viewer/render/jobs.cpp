// SPDX-License-Identifier: MIT
#include "app/viewer/render/jobs.h"

#include <system_error>

#include <fmt/format.h>

#include "app/inspect/construction.h"
#include "app/inspect/mapped_frame.h"
#include "app/measure/scene_facts.h"
#include "app/measure/zoom_path.h"
#include "app/report/stats_file.h"
#include "app/report/write_report.h"
#include "app/report/zoom_recording.h"
#include "app/session/frame_metadata.h"
#include "app/session/shot.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

Progress upload_progress(RenderContext& context, const Scene& scene) {
  return loading_progress(scene.path, "uploading", context.stop, context.report);
}

std::unique_ptr<Renderer> uploaded(RenderContext& context, const Scene& scene, Backend backend) {
  auto renderer = make_renderer(backend, context.options);
  renderer->upload(scene.cloud, upload_progress(context, scene));
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

Renderer& renderer_on(RenderContext& context, Backend backend) {
  Session& session = context.session;
  if (backend == session.backend || session.second) return renderer_on(session, backend);
  const ReportAtEnd end(context, action::SetLoading{});
  return renderer_on(session, backend, upload_progress(context, session.scene));
}

fs::path free_name(const fs::path& folder, const std::string& stem, const std::string& ending) {
  for (int n = 1;; ++n) {
    fs::path path = folder / fmt::format("{}_{:04}{}", stem, n, ending);
    std::error_code error;
    if (!fs::exists(path, error)) return path;
  }
}

Job open_scene(LoadedScene loaded, Backend backend, RenderSettings settings, bool keep_background) {
  return [loaded = std::move(loaded), backend, settings,
          keep_background](RenderContext& context) mutable {
    const ReportAtEnd end(context, action::SetLoading{});
    auto renderer = uploaded(context, loaded.scene, backend);
    if (!keep_background)
      settings.background = glm::vec3(loaded.facts.white_background ? 1.0f : 0.0f);
    Session& session = context.session;
    session.second.reset();
    context.reference.reset();
    session.renderer = std::move(renderer);
    session.scene = std::move(loaded.scene);
    session.backend = backend;
    session.options = context.options;
    session.settings = settings;
    context.report(action::SceneOpened{std::move(loaded.facts), settings, backend});
  };
}

Job switch_backend(Backend backend) {
  return [backend](RenderContext& context) {
    const ReportAtEnd end(context, action::SetLoading{});
    Session& session = context.session;
    session.second.reset();
    session.renderer = uploaded(context, session.scene, backend);
    session.backend = backend;
    context.report(action::BackendChanged{backend});
  };
}

Job pick_pivot(FrameOrder order, glm::ivec2 pixel) {
  return [order = std::move(order), pixel](RenderContext& context) {
    const auto point = find_point(*context.session.renderer, order.camera, order.settings, pixel);
    if (point) {
      context.report(action::SetPivot{*point});
    } else {
      context.report(action::Say{"nothing is under the cursor"});
    }
  };
}

Job take_screenshot(FrameOrder order, std::string camera_name, fs::path folder) {
  return [order = std::move(order), camera_name = std::move(camera_name),
          folder = std::move(folder)](RenderContext& context) {
    Renderer& renderer = *context.session.renderer;
    const Camera& camera = order.camera;
    std::optional<MappedFrame> mapped;
    if (order.heatmap)
      mapped.emplace(draw_mapped(renderer, camera, order.settings, *order.heatmap,
                                 context.options.threads, context.stop));
    const Frame& frame =
        mapped ? mapped->frame
               : renderer.render(camera, order.settings, {}, HostImage{}, context.stop);
    const char* mode = mode_name(order.settings.mode);
    const fs::path scene = context.session.scene.path;
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
    context.report(action::Say{fmt::format("wrote {}", path.string())});
  };
}

Job record_zoom_from(FrameOrder order, glm::ivec2 pixel, fs::path folder) {
  return [order = std::move(order), pixel, folder = std::move(folder)](RenderContext& context) {
    Session& session = context.session;
    const WithSettings settings(session, order.settings);
    const auto target = find_point(*session.renderer, order.camera, order.settings, pixel);
    if (!target) {
      context.report(action::ZoomEnded{});
      return context.report(
          action::Say{"nothing is in the middle of the picture to zoom to", true});
    }
    const ZoomPlan plan = zoom_plan(session.backend);
    ZoomBundle bundle = start_zoom(session, order.camera, *target);
    bundle.steps = plan.steps;
    context.report(action::ZoomStepped{bundle.steps, {}});
    FrameOrder shown = order;
    const auto on_step = [&](const Camera& camera, const std::vector<BenchRow>& rows) {
      context.report(action::ZoomStepped{bundle.steps, rows});
      shown.camera = camera;
      context.show(shown);
    };
    try {
      bundle.rows = record_zoom(session, bundle, plan.plan, {{}, context.stop}, on_step);
      const fs::path path = free_name(folder / "zoom", scene_name(session.scene.path), "");
      const std::string problem = save_zoom(session, bundle, path);
      if (!problem.empty()) context.report(action::Say{problem});
      context.report(action::ZoomEnded{path});
      context.report(action::Say{fmt::format("wrote {}", path.string())});
    } catch (...) {
      context.report(action::ZoomEnded{});
      context.report(action::Say{"the zoom was stopped, nothing was saved"});
      throw;
    }
  };
}

Job bench_view(FrameOrder order, std::string camera_name, fs::path folder) {
  return [order = std::move(order), camera_name = std::move(camera_name),
          folder = std::move(folder)](RenderContext& context) {
    Session& session = context.session;
    const WithSettings settings(session, order.settings);
    context.report(action::MeasuringChanged{true});
    const ReportAtEnd end(context, action::MeasuringChanged{false});
    BenchReport report;
    report.environment = environment_json(session);
    const std::string name = scene_name(session.scene.path);
    report.scenes.push_back(scene_facts(session.scene, name));
    report.rows = measure_view(session, all_modes(), order.camera, bench_plan(session.backend),
                               {{}, context.stop});
    for (BenchRow& row : report.rows) {
      row.scene = name;
      row.camera = camera_name;
    }
    const fs::path path = free_name(folder / "bench", name, "");
    const std::string problem = write_report(report, path);
    if (!problem.empty()) context.report(action::Say{problem});
    context.report(action::NumbersMeasured{{order.view_version, report.rows}});
    context.report(action::Say{fmt::format("wrote {}", path.string())});
  };
}

Job inspect_view(FrameOrder order, glm::ivec2 pixel, std::optional<std::uint32_t> gaussian) {
  return [order = std::move(order), pixel, gaussian](RenderContext& context) {
    const Frame& frame = context.session.renderer->render(
        order.camera, order.settings, inspection_outputs(), HostImage{}, context.stop);
    const glm::ivec2 size(order.camera.width, order.camera.height);
    InspectedView view{
        order.version, inspect(frame, size, pixel, order.settings.background, gaussian), {}};
    if (view.inspection.gaussian) {
      view.construction = draw_construction(
          {view.inspection, frame.color, frame.grid, scene_name(context.session.scene.path)});
    }
    context.report(action::PixelInspected{std::move(view)});
  };
}

Job ask_oracle_about(FrameOrder order, std::optional<PixelBox> region) {
  return [order = std::move(order), region](RenderContext& context) {
    constexpr int kTolerance = 2;  // of 8-bit values
    const ReportAtEnd end(context, action::SetLoading{});
    Outputs outputs;
    outputs.trace = true;
    const Frame frame = context.session.renderer->render(order.camera, order.settings, outputs,
                                                         HostImage{}, context.stop);
    Renderer& cpu = renderer_on(context, Backend::cpu);
    const Progress progress = loading_progress(
        context.session.scene.path, "computing the reference of", context.stop, context.report);
    progress.update(0);
    Image truth = reference_of(cpu, order.camera, order.settings, region, progress);
    const Verdict verdict =
        judge(cpu, order.camera, order.settings, frame, truth, region, kTolerance, progress);
    context.reference = ReferenceImage{order.view_version, verdict.region, std::move(truth)};
    context.report(action::OracleAnswered{{order.version, verdict,
                                           fmt::format("{}: {}", mode_name(order.settings.mode),
                                                       verdict_sentence(verdict, kTolerance))}});
    if (order.other) context.show(order);
  };
}

}  // namespace qs
