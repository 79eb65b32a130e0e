// SPDX-License-Identifier: MIT
#include "app/viewer/render/upload_scene.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "app/picture/palette.h"
#include "app/session/levels.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/render/resolution.h"
#include "base/error.h"
#include "raster/kernel/constants.h"
#include "raster/scene/cloud_order.h"

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
  const Camera camera = reduced(request.camera, kDivisor);
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

// The facts of a scene, with other Gaussians.
std::shared_ptr<Scene> with_cloud(const Scene& scene, GaussianCloud cloud) {
  auto result = std::make_shared<Scene>();
  result->path = scene.path;
  result->format = scene.format;
  result->axes = scene.axes;
  result->declared_axes = scene.declared_axes;
  result->vertical_axis = scene.vertical_axis;
  result->file_bytes = scene.file_bytes;
  result->edits = scene.edits;
  result->cloud = std::move(cloud);
  return result;
}

// The numbers in the whole scene of the Gaussians that are left.
std::vector<std::uint32_t> left_of(const CropRequest& request) {
  return request.gone->complement().numbers();
}

// The Gaussians of the rest that are wished away or selected.
Removal removal_by(const GaussianCloud& rest, const CropRequest& request) {
  Removal removal = find_removal(rest, request.wish.used_box(), request.wish.used_floaters());
  if (!request.selected) return removal;
  if (!request.gone) {
    request.selected->for_each([&](std::size_t i) { removal.select(i); });
    return removal;
  }
  const std::vector<std::uint32_t> numbers = left_of(request);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if ((*request.selected)[numbers[i]]) removal.select(i);
  return removal;
}

// Replaces the scene of the session's renderer, or leaves everything as it is and throws.
void show(RenderContext& context, const std::shared_ptr<const Scene>& scene) {
  Session& session = context.session;
  if (scene == session.scene) return;
  session.second.reset();
  context.reference.reset();
  upload_making_room(context, *session.renderer, scene, {});
  session.scene = scene;
}

// The last rest is kept, because dragging a box asks often.
std::shared_ptr<const Scene> rest_of(const RenderContext& context,
                                     const std::shared_ptr<const Scene>& whole,
                                     const CropRequest& request) {
  if (!request.gone) return whole;
  if (context.cropped && context.cropped->gone == request.gone) return context.cropped->rest;
  auto rest = with_cloud(*whole, select(whole->cloud, left_of(request)));
  rest->edits.remove(whole->cloud.size(), [&](std::size_t i) { return (*request.gone)[i]; });
  rest->edits.steps = whole->edits.steps + request.steps;
  return rest;
}

std::optional<RemovalCounts> carry_out(RenderContext& context, const CropRequest& request) {
  const std::shared_ptr<const Scene> whole = whole_scene(context);
  const std::shared_ptr<const Scene> rest = rest_of(context, whole, request);
  std::optional<Removal> removal;
  if (request.view != CropView::rest) removal = removal_by(rest->cloud, request);
  const bool tints = request.view == CropView::marked && removal->going() > 0;
  if (tints) {
    auto marked = with_cloud(*rest, tinted(rest->cloud, *removal));
    marked->edits.tinted = true;
    show(context, marked);
  } else {
    show(context, rest);
  }
  context.cropped.reset();
  if (tints || rest != whole) context.cropped = CroppedScene{whole, request.gone, rest};
  return removal;
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
  context.cropped.reset();
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

GaussianCloud tinted(GaussianCloud cloud, const Removal& removal) {
  constexpr float kOld = 0.3f;
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  const glm::vec3 tint = (kVermillion - 0.5f) / static_cast<float>(kSh0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (removal.marks[i] == Removed::no) continue;
    glm::vec3* sh = &cloud.sh[i * coefficients];
    for (std::size_t k = 0; k < coefficients; ++k) sh[k] *= kOld;
    sh[0] += (1 - kOld) * tint;
  }
  return cloud;
}

Job show_crop(const CropRequest& request) {
  return [request](RenderContext& context) {
    try {
      const std::optional<RemovalCounts> counts = carry_out(context, request);
      context.report(action::scene_edited, EditFacts(context.session.scene->edits));
      context.report(action::crop_shown, request, counts,
                     std::uint64_t{context.session.scene->cloud.size()});
    } catch (const std::bad_alloc&) {
      context.report(action::crop_failed, std::string("there is not enough memory to crop"));
    } catch (const std::exception& error) {
      context.report(action::crop_failed, std::string(error.what()));
    }
  };
}

}  // namespace qs
