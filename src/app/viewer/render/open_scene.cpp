// SPDX-License-Identifier: MIT
#include "app/viewer/render/open_scene.h"

#include "app/viewer/render/render_context.h"

namespace qs {
namespace {

Progress upload_progress(RenderContext& context, const Scene& scene) {
  return shown_progress(scene.path, "uploading", context.stop, context.reports);
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

Job open_scene(std::shared_ptr<LoadedScene> loaded, Backend backend, RenderSettings settings,
               bool keep_background) {
  return [=](RenderContext& context) mutable {
    const auto end = hide_progress_at_end(context);
    const auto scene = std::make_shared<const Scene>(std::move(loaded->scene));
    auto renderer = upload_to(context, scene, backend);
    if (!keep_background)
      settings.background = glm::vec3(loaded->facts.white_background ? 1.0f : 0.0f);
    Session& session = context.session;
    session.second.reset();
    context.reference.reset();
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

}  // namespace qs
