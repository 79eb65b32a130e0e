// SPDX-License-Identifier: MIT
#include "app/viewer/render/open_scene.h"

#include "app/viewer/render/render_context.h"

namespace qs {

std::unique_ptr<Renderer> upload_to(RenderContext& context,
                                    const std::shared_ptr<const Scene>& scene, Backend backend) {
  auto renderer = make_renderer(backend, *context.session.pool, context.session.device);
  renderer->upload(cloud_of(scene),
                   shown_progress(scene->path, "uploading", context.stop, context.reports));
  return renderer;
}

Renderer& renderer_on(RenderContext& context, Backend backend) {
  Session& session = context.session;
  if (backend == session.backend) return *session.renderer;
  if (!context.second) {
    const auto end = hide_progress_at_end(context);
    context.second = upload_to(context, session.scene, backend);
  }
  return *context.second;
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
    context.second.reset();
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
