// SPDX-License-Identifier: MIT
#include "app/viewer/render/open_scene.h"

#include <algorithm>
#include <cmath>

#include "app/viewer/render/host_frames.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/render/resolution.h"

namespace qs {
namespace {

Progress upload_progress(RenderContext& context, const Scene& scene) {
  return shown_progress(scene.path, "uploading", context.stop, context.reports);
}

RenderSettings settings_for(const ViewedScene& facts, RenderSettings settings,
                            bool keep_background) {
  if (!keep_background) settings.background = glm::vec3(facts.white_background ? 1.0f : 0.0f);
  return settings;
}

// Draws on the CPU with any backend, because a separate CPU renderer is made quickly.
Job draw_sample(const std::shared_ptr<ReadSample>& read, FrameRequest request) {
  constexpr double kLargest = 16;  ///< times as large as in the scene
  constexpr int kDivisor = 2;      ///< the sample shows no details
  return [=](RenderContext& context) mutable {
    // Fewer Gaussians are drawn larger, so that they cover the same area.
    const double larger = std::min(std::sqrt(static_cast<double>(read->sample.step)), kLargest);
    request.divisor = kDivisor;
    request.settings = reduced(request.settings, kDivisor);
    request.settings.splat_scale *= static_cast<float>(larger);
    const auto renderer = make_renderer(Backend::cpu, *context.session.pool);
    renderer->upload(std::move(read->sample.scene.cloud), {});
    const Camera camera = reduced(request.camera, kDivisor);
    context.present(rendered_of(
        request, renderer->render(camera, request.settings, {}, HostImage{}, context.stop)));
  };
}

}  // namespace

std::unique_ptr<Renderer> upload_to(RenderContext& context,
                                    const std::shared_ptr<const Scene>& scene, Backend backend) {
  auto renderer = make_renderer(backend, *context.session.pool, context.session.device);
  renderer->upload(cloud_of(scene), upload_progress(context, *scene));
  return renderer;
}

Renderer& renderer_on(RenderContext& context, Backend backend) {
  Session& session = context.session;
  if (backend == session.backend || session.second) return renderer_on(session, backend);
  const auto end = hide_progress_at_end(context);
  return renderer_on(session, backend, upload_progress(context, *session.scene));
}

Renderer& renderer_beside(RenderContext& context) {
  RenderedBeside& beside = *context.beside;
  if (beside.renderer == nullptr || beside.backend != context.session.backend) {
    const auto end = hide_progress_at_end(context);
    beside.renderer.reset();  // the old and the new renderer may not fit into memory together
    beside.renderer = upload_to(context, beside.scene, context.session.backend);
    beside.backend = context.session.backend;
  }
  return *beside.renderer;
}

Job open_beside(const std::shared_ptr<const Scene>& scene, Backend backend) {
  return [=](RenderContext& context) {
    const auto end = hide_progress_at_end(context);
    auto renderer = upload_to(context, scene, backend);
    const SceneBeside facts{scene->path, scene->cloud.size()};
    context.beside = RenderedBeside{scene, facts, backend, std::move(renderer)};
    context.report(action::beside_opened, facts);
  };
}

Job open_scene(const std::shared_ptr<LoadedScene>& loaded, Backend backend, RenderSettings settings,
               bool keep_background) {
  return [=](RenderContext& context) mutable {
    const auto end = hide_progress_at_end(context);
    const auto scene = std::make_shared<const Scene>(std::move(loaded->scene));
    auto renderer = upload_to(context, scene, backend);
    settings = settings_for(loaded->facts, settings, keep_background);
    Session& session = context.session;
    session.second.reset();
    context.reference.reset();
    context.cropped.reset();
    session.renderer = std::move(renderer);
    session.scene = scene;
    session.backend = backend;
    session.settings = settings;
    context.report(action::scene_opened, std::move(loaded->facts), settings, backend);
  };
}

void action::scene_read(Viewer& viewer, Host& host, const std::shared_ptr<LoadedScene>& loaded,
                        bool keep_background) {
  host.run(open_scene(loaded, viewer.backend, viewer.settings, keep_background));
}

void action::beside_read(Viewer& viewer, Host& host, const std::shared_ptr<const Scene>& scene) {
  host.run(open_beside(scene, viewer.backend));
}

void action::sample_read(Viewer& viewer, Host& host, const std::shared_ptr<ReadSample>& read,
                         bool keep_background) {
  if (viewer.scene) return;
  Viewer opened = viewer;
  opened.panels.photograph = false;  // it is not read yet
  const RenderSettings settings = settings_for(read->facts, viewer.settings, keep_background);
  scene_opened(opened, host, read->facts, settings, viewer.backend);
  FrameRequest request;
  request.camera = opened.camera;
  request.settings = settings;
  request.settings.mode = viewer.mode();
  host.run(draw_sample(read, request));
}

}  // namespace qs
