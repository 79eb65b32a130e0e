// SPDX-License-Identifier: MIT
#include "app/viewer/render/crop_scene.h"

#include <memory>

#include "app/picture/palette.h"
#include "app/session/removal_text.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/render/upload_scene.h"
#include "base/fail.h"
#include "raster/kernel/constants.h"

namespace qs {
namespace {

std::shared_ptr<const Scene> with_cloud(const Scene& scene, GaussianCloud cloud) {
  auto result = std::make_shared<Scene>();
  result->path = scene.path;
  result->format = scene.format;
  result->axes = scene.axes;
  result->declared_axes = scene.declared_axes;
  result->vertical_axis = scene.vertical_axis;
  result->file_bytes = scene.file_bytes;
  result->cloud = std::move(cloud);
  return result;
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

// The scene after earlier crops. The last such scene is kept, because dragging a box asks often.
std::shared_ptr<const Scene> rest_of(const RenderContext& context,
                                     const std::shared_ptr<const Scene>& whole,
                                     const std::vector<CropWish>& done) {
  if (done.empty()) return whole;
  if (context.cropped && context.cropped->done == done && context.cropped->base)
    return context.cropped->base;
  std::shared_ptr<const Scene> rest = whole;
  for (const CropWish& wish : done) {
    const Removal removal = find_removal(rest->cloud, wish.used_box(), wish.used_floaters());
    rest = with_cloud(*whole, keep_rest(rest->cloud, removal));
  }
  return rest;
}

std::optional<RemovalCounts> carry_out(RenderContext& context, const CropRequest& request) {
  Session& session = context.session;
  const std::shared_ptr<const Scene> whole =
      context.cropped ? context.cropped->whole : session.scene;
  if (request.view == CropView::whole) {
    show(context, whole);
    context.cropped.reset();
    return std::nullopt;
  }
  const std::shared_ptr<const Scene> base = rest_of(context, whole, request.done);
  const GaussianCloud& cloud = base->cloud;
  const Removal removal =
      find_removal(cloud, request.wish.used_box(), request.wish.used_floaters());
  if (request.view == CropView::rest && removal.staying() == 0)
    fail("{}: {}", whole->path.string(), removal_text(removal, "would go"));
  if (removal.going() == 0 || request.view == CropView::counted) {
    show(context, base);
    context.cropped.reset();
    if (base != whole) context.cropped = CroppedScene{whole, false, request.done, base};
  } else {
    const bool tints = request.view == CropView::marked;
    show(context, with_cloud(*whole, tints ? tinted(cloud, removal) : keep_rest(cloud, removal)));
    context.cropped = CroppedScene{whole, tints, request.done, base};
  }
  return removal;
}

}  // namespace

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
      context.report(action::crop_shown, request, counts,
                     std::uint64_t{context.session.scene->cloud.size()});
    } catch (const std::bad_alloc&) {
      context.report(action::crop_failed, std::string("there is not enough memory to crop"));
    } catch (const std::exception& error) {
      context.report(action::crop_failed, std::string(error.what()));
    }
  };
}

void action::follow_crop(Viewer& viewer, Host& host) {
  const CropRequest wanted = wanted_crop(viewer);
  if (viewer.crop.busy || wanted == viewer.crop.asked) return;
  viewer.crop.busy = true;
  viewer.crop.asked = wanted;
  host.run(show_crop(wanted));
}

}  // namespace qs
