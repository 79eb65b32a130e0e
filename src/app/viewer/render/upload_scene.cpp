// SPDX-License-Identifier: MIT
#include "app/viewer/render/upload_scene.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "app/session/levels.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/render/resolution.h"
#include "base/error.h"

namespace qs {
Progress upload_progress(RenderContext& context, const Scene& scene) {
  return shown_progress(scene.path, "uploading", context.stop, context.reports);
}

std::unique_ptr<Renderer> upload_to(RenderContext& context,
                                    const std::shared_ptr<const Scene>& scene, Backend backend,
                                    const Progress& progress) {
  auto renderer = context.make_renderer(backend, context.session);
  expect_stream(*renderer, scene->stream);
  renderer->upload(cloud_of(scene), progress);
  if (scene == context.session.scene) leave_out(context.session, *renderer);
  return renderer;
}

RenderSettings settings_for(const ViewedScene& facts, RenderSettings settings,
                            bool keep_background) {
  if (!keep_background) settings.background = glm::vec3(facts.white_background ? 1.0f : 0.0f);
  return settings;
}

void draw_sample(RenderContext& context, SceneSample& sample, FrameRequest request) {
  constexpr double kLargest = 16;  ///< times as large as in the scene
  constexpr int kDivisor = 2;      ///< the sample shows no details
  // Fewer Gaussians are drawn larger, so that they cover the same area.
  const double larger = std::min(std::sqrt(static_cast<double>(sample.step)), kLargest);
  request.divisor = kDivisor;
  request.settings = reduced(request.settings, kDivisor);
  request.settings.splat_scale *= static_cast<float>(larger);
  const auto renderer = make_renderer(Backend::cpu, *context.session.pool);
  renderer->upload(std::move(sample.scene.cloud), {});
  const Camera camera = request.camera.reduced(kDivisor);
  context.present(rendered_of(
      context, request, renderer->render(camera, request.settings, {}, HostImage{}, context.stop)));
}

namespace {

// Frees the renderers that are made again when they are needed, except `kept`. False if there are
// none.
bool free_renderers(RenderContext& context, const Renderer* kept) {
  bool any = false;
  const auto free = [&](std::unique_ptr<Renderer>& renderer) {
    if (renderer == nullptr || renderer.get() == kept) return;
    renderer.reset();
    any = true;
  };
  free(context.session.second);
  if (context.beside) free(context.beside->renderer);
  return any;
}

// As upload_to(), but frees the other renderers if memory is short.
std::unique_ptr<Renderer> make_room_and_upload(RenderContext& context,
                                               const std::shared_ptr<const Scene>& scene,
                                               Backend backend, const Progress& progress) {
  auto renderer = context.make_renderer(backend, context.session);
  upload_making_room(context, *renderer, scene, progress);
  return renderer;
}

// Shows the scene without the Gaussians of the request. Finds the Gaussians of the rest that are
// wished away or selected.
ShownCrop carry_out(RenderContext& context, const CropRequest& request) {
  Session& session = context.session;
  if (session.gone != request.gone) context.reference.reset();
  if (session.scene->stream) {
    edit_pages(session, request.pages);
    return {
        .tint = request.selected, .edits = edits_of(session), .gaussians = drawn_count(session)};
  }
  leave_out(session, request.gone, request.steps);
  ShownCrop shown{.edits = edits_of(session), .gaussians = drawn_count(session)};
  if (!request.counts()) return shown;
  RemovalCounts& counts = shown.counts.emplace();
  GaussianSet tint(session.scene->cloud.size());
  counts.counts[0] = shown.gaussians;
  if (request.wish.removes()) {
    const GaussianSet rest = (request.gone ? *request.gone : tint).complement();
    const Removal removal = find_removal(session.scene->cloud, request.wish.used_box(),
                                         request.wish.used_floaters(), {}, &rest);
    tint = removal.gone(*session.pool);
    counts = removal;
  }
  if (request.selected) {
    const std::size_t others = tint.count();
    tint |= *request.selected;
    counts.add_selected(tint.count() - others);
  }
  if (!tint.empty()) shown.tint = std::make_shared<const GaussianSet>(std::move(tint));
  return shown;
}

}  // namespace

void upload_making_room(RenderContext& context, Renderer& renderer,
                        const std::shared_ptr<const Scene>& scene, const Progress& progress) {
  expect_stream(renderer, scene->stream);
  try {
    renderer.upload(cloud_of(scene), progress);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::device || !free_renderers(context, &renderer)) throw;
    expect_stream(renderer, scene->stream);
    renderer.upload(cloud_of(scene), progress);
  }
}

OpenedScene show_scene(RenderContext& context, const UploadOrder& order, const Progress& progress) {
  Session& session = context.session;
  session.second.reset();  // is uploaded again when it is needed
  if (session.renderer == nullptr) {
    session.renderer = make_room_and_upload(context, order.scene, order.backend, progress);
  } else if (session.backend == order.backend) {
    upload_making_room(context, *session.renderer, order.scene, progress);
  } else {
    change_renderer(session, order.backend, [&](Backend backend) {
      return backend == order.backend
                 ? make_room_and_upload(context, order.scene, backend, progress)
                 : upload_to(context, session.scene, backend, {});
    });
  }
  context.reference.reset();
  session.gone = nullptr;
  session.pages = nullptr;
  session.scene = order.scene;
  session.backend = order.backend;
  session.settings = order.settings;
  return {order.facts, order.settings, order.backend};
}

SceneBeside show_beside(RenderContext& context, const std::shared_ptr<const Scene>& scene,
                        Backend backend, const Progress& progress) {
  std::optional<RenderedBeside>& old = context.beside;
  const bool reuses = old && old->renderer != nullptr && old->backend == backend;
  // The renderer of another backend is made again when it is needed.
  if (old && !reuses) old->renderer.reset();
  if (reuses) upload_making_room(context, *old->renderer, scene, progress);
  auto renderer =
      reuses ? std::move(old->renderer) : make_room_and_upload(context, scene, backend, progress);
  const SceneBeside facts{scene->path, scene->cloud.size()};
  context.beside = RenderedBeside{scene, facts, backend, std::move(renderer)};
  return facts;
}

void change_renderer(Session& session, Backend backend,
                     const std::function<std::unique_ptr<Renderer>(Backend)>& upload) {
  session.second.reset();
  session.renderer.reset();
  try {
    session.renderer = upload(backend);
  } catch (...) {
    session.renderer = upload(session.backend);
    throw;
  }
  session.backend = backend;
}

Renderer& renderer_on(RenderContext& context, Backend backend) {
  Session& session = context.session;
  if (backend == session.backend || session.second) return renderer_on(session, backend);
  const auto end = hide_progress_at_end(context);
  const Progress progress = upload_progress(context, *session.scene);
  // A window does not wait for cuts.
  if (session.scene->stream) session.second = upload_to(context, session.scene, backend, progress);
  return renderer_on(session, backend, progress);
}

Renderer& renderer_beside(RenderContext& context) {
  RenderedBeside& beside = *context.beside;
  if (beside.renderer == nullptr || beside.backend != context.session.backend) {
    const auto end = hide_progress_at_end(context);
    beside.renderer.reset();  // the old and the new renderer may not fit into memory together
    beside.renderer = upload_to(context, beside.scene, context.session.backend,
                                upload_progress(context, *beside.scene));
    beside.backend = context.session.backend;
  }
  return *beside.renderer;
}

Job show_crop(const CropRequest& request) {
  return [request](RenderContext& context) {
    try {
      context.report(action::crop_shown, request, carry_out(context, request));
    } catch (const std::bad_alloc&) {
      context.report(action::crop_failed, std::string("there is not enough memory to crop"));
    } catch (const std::exception& error) {
      context.report(action::crop_failed, std::string(error.what()));
    }
  };
}

}  // namespace qs
