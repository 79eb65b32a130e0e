// SPDX-License-Identifier: MIT
//
// Selections of Gaussians, and points of surfaces.
#include <limits>
#include <memory>
#include <string>

#include "base/fail.h"
#include "io/edits/edits_file.h"
#include "library/api/scene.h"
#include "library/check/arrays.h"
#include "library/check/structs.h"
#include "raster/select/editing.h"
#include "raster/select/surface.h"

using namespace qs::library;

namespace {

/// The tools draw the whole scene with its renderer, and a rest with a renderer of its own.
SeenInPicture seen_in(OpenScene& scene, const Use& use) {
  const std::shared_ptr<const GaussianCloud> cloud(std::shared_ptr<void>(), &scene.cloud());
  return [&scene, &use, cloud, rest_renderer = std::shared_ptr<Renderer>(),
          seen_in_rest = SeenInPicture()](const GaussianSet& rest, const Camera& camera,
                                          const Shape& shape, float weight) mutable {
    if (rest.count() == rest.size())
      return seen_by(scene.renderer(use.stop()), *cloud, camera, shape, weight, use.pool(),
                     use.stop());
    if (!rest_renderer) {
      rest_renderer = scene.context().make_renderer();
      seen_in_rest = seen_with(*rest_renderer, cloud, use.pool(), false, use.stop());
    }
    return seen_in_rest(rest, camera, shape, weight);
  };
}

void store_set(const OpenScene& scene, const GaussianSet& set, const QsArray& array,
               ThreadPool& pool) {
  auto* const values = static_cast<std::uint8_t*>(array.data);
  pool.for_each(static_cast<std::size_t>(array.sizes[0]), 1 << 16, [&](std::size_t number) {
    const auto index = scene.index_of(number);
    values[static_cast<std::ptrdiff_t>(number) * array.strides[0]] = index && set[*index] ? 1 : 0;
  });
}

QsSurfacePoint point_of(const std::optional<SurfacePoint>& point) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (!point) return {{kNone, kNone, kNone}, {kNone, kNone, kNone}, kNone, kNone, kNone, kNone};
  const glm::dvec3 &at = point->position, &to = point->direction;
  return {{at.x, at.y, at.z}, {to.x, to.y, to.z}, point->distance,
          point->along,       point->across,      kNone};
}

}  // namespace

int32_t qs_select(QsSceneHandle* scene, const char* edits, const QsArray* selected,
                  const QsArray* left, char* message) {
  return library::call(__func__, message, "scene", scene, [&](const char* function) {
    require_text(edits, {function, "edits"});
    OpenScene& open = scene->scene;
    const auto count = static_cast<std::int64_t>(open.facts().gaussians);
    for (const auto& [array, name] : {std::pair(selected, "selected"), std::pair(left, "left")})
      if (array != nullptr) check_array(*array, {function, name}, {count}, kBytes, Access::writes);
    const Use use(open.context(), {function, "scene"});
    const GaussianCloud& cloud = open.cloud();
    const EditsFile file = parse_edits(edits, "edits", cloud.origin);
    if (file.scene.gaussians != 0 && file.scene.gaussians != cloud.size())
      fail("edits: they are of a scene of {} Gaussians, and this scene has {}",
           file.scene.gaussians, cloud.size());
    EditState state(cloud.size());
    const EditTools tools{cloud, use.pool(), seen_in(open, use), set_hash, {{}, use.stop()}};
    for (std::size_t i = 0; i < file.steps.size(); ++i)
      carry_out(file.steps[i], tools, fmt::format("edits: step {}", i + 1), state);
    if (selected != nullptr) store_set(open, state.selected, *selected, use.pool());
    if (left != nullptr) store_set(open, state.rest(), *left, use.pool());
  });
}

int32_t qs_measure(QsSceneHandle* scene, const QsCamera* camera, const QsSettings* settings,
                   const int32_t* pixels, uint64_t count, QsSurfacePoint* points, char* message) {
  return library::call(__func__, message, "scene", scene, [&](const char* function) {
    const Camera view = camera_of(camera, {function, "camera"});
    const RenderSettings chosen = settings_of(settings, {function, "settings"});
    if (chosen.mode == kReferenceMode)
      refuse({function, "settings"}, "the mode reference has no tiles: choose another mode");
    if (count == 0) return;
    require(pixels, {function, "pixels"});
    require(points, {function, "points"});
    for (std::uint64_t i = 0; i < count; ++i)
      if (pixels[2 * i] < 0 || pixels[2 * i + 1] < 0 || pixels[2 * i] >= view.width ||
          pixels[2 * i + 1] >= view.height)
        refuse({function, "pixels", static_cast<std::int64_t>(i)},
               "{},{} is outside of the picture of {} x {}", pixels[2 * i], pixels[2 * i + 1],
               view.width, view.height);
    const Use use(scene->scene.context(), {function, "scene"});
    const Frame& frame =
        scene->scene.renderer(use.stop())
            .render(view, chosen, {.color = false, .trace = true}, HostImage{}, use.stop());
    std::optional<SurfacePoint> last;
    for (std::uint64_t i = 0; i < count; ++i) {
      const auto point =
          surface_at(frame, scene->scene.cloud(), view, {pixels[2 * i], pixels[2 * i + 1]});
      points[i] = point_of(point);
      if (last && point) points[i - 1].to_next = length_between(*last, *point).error;
      last = point;
    }
  });
}
