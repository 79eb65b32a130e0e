// SPDX-License-Identifier: MIT
//
// Jobs of measuring: the surface at a pixel, the parts of rulers behind surfaces, the box of the
// selection, and the file of measures.
#include <cmath>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "app/session/scene_edits.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/render/measured_view.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/measure_actions.h"
#include "base/text.h"
#include "io/bytes/replace_file.h"

namespace qs {
namespace {

void measure_at(RenderContext& context, const Viewer& v, glm::dvec2 pixel) {
  std::optional<SurfacePoint> point;
  const AtEnd end{[&] { context.report(action::point_measured, point); }};
  point = MeasuredView(context, v.camera).surface(pixel);
}

// True if a surface is in front of the place.
bool is_hidden(const MeasuredView& view, glm::dvec3 place) {
  constexpr double kOnSurface = 0.01;  // of the distance
  const glm::dvec3 seen = view.camera.view_from_world * glm::dvec4(place, 1);
  if (seen.z <= view.camera.near_depth) return false;
  const glm::dvec2 pixel = glm::dvec2(seen) / seen.z * view.camera.focal_px + view.camera.center_px;
  const auto surface = view.surface(pixel);
  return surface && glm::length(seen) > (1 + kOnSurface) * surface->distance + surface->along;
}

void look_behind(RenderContext& context, const Viewer& v) {
  std::vector<std::vector<bool>> hidden;  // empty if it is cancelled
  const AtEnd end{[&] { context.report(action::rulers_hidden, int{v.view_version}, hidden); }};
  const MeasuredView view(context, v.camera);
  std::vector<std::vector<bool>> found;
  for (const Ruler& ruler : rulers_of(v)) {
    auto& parts = found.emplace_back();
    for (std::size_t i = 0; i < kRulerParts; ++i)
      parts.push_back(is_hidden(view, glm::mix(ruler.from.position, ruler.to.position,
                                               (static_cast<double>(i) + 0.5) / kRulerParts)));
  }
  hidden = std::move(found);
}

std::string file_text(const Scene& scene, const Measures& measures, bool hashes) {
  return format_measures({edited_scene(scene, hashes), measures}, scene.cloud.origin);
}

void write_measures(RenderContext& context, const Viewer& viewer, const Action& then) {
  const OutputFile output(viewer, "", viewer.scene->name, ".measures.json");
  write_text(output.path(), file_text(*context.session.scene, viewer.measures, true));
  output.done(context, fmt::format(" ({})", counted(viewer.measures.points(), "point")));
  context.report([saved = Measures(viewer.measures)](Viewer& v, Host&) {
    if (!v.keeps_work || !v.measures.keeps) v.measures.kept = saved;
  });
  if (then) context.report(then);
}

// The last point is where its line of sight crosses the line of a pixel of this view.
void cross_sights(Viewer& v, glm::dvec2 pixel) {
  SurfacePoint* const point = v.measures.last_point();
  v.measures.again = false;
  if (point == nullptr || !(point->distance > 0))
    return action::notify(v, "set a point first, then turn the view and show it again");
  const auto found = crossing(sight_of(*point), sight_of(v.camera, pixel));
  if (!found)
    return action::notify(v, "both lines of sight are parallel: turn the view, then show it again");
  const MeasureScale& scale = v.measures.scale;
  const double from_surface = glm::distance(point->position, found->point.position);
  *point = found->point;
  v.measures.hidden_version = v.measures.asked_version = -1;
  action::notify(
      v, fmt::format("the last point from two views: ± {:.2g} {}; the lines of sight miss each "
                     "other by {:.2g}, the surface was {:.2g} away",
                     scale.factor * std::hypot(point->along, point->across), scale.name(),
                     scale.factor * found->gap, scale.factor * from_surface));
}

}  // namespace

void action::save_measures(Viewer& v, Host& host, const Action& then) {
  if (v.scene) start_job(v, host, write_measures, then);
}

void action::open_measures(Viewer& v, Host& host, const std::filesystem::path& file,
                           const std::optional<std::string>& text) {
  if (!v.scene) return;
  host.run([=](RenderContext& context) {
    const MeasuresFile read = measures_of(*context.session.scene, file, text);
    for (const std::string& sentence : read.warnings) context.report(action::notify, sentence);
    context.report(action::measures_opened, file, read.measures);
  });
}

void action::keep_measures(Viewer& v, Host& host, const Action& then) {
  const auto text = [measures = v.measures.kept = v.measures](const Scene& scene) {
    return measures == Measures() ? std::string() : file_text(scene, measures, false);
  };
  keep_beside(v, host, {".measures.json", "measures", v.measures.owns_file, text, measures_kept},
              then);
}

void action::measure_pixel(Viewer& v, Host& host, glm::dvec2 pixel) {
  if (!v.scene || v.measures.busy) return;
  if (v.settings.lens) return notify(v, "points are measured by a pinhole camera (Shift+5)");
  if (v.measures.again) return cross_sights(v, pixel);
  v.measures.busy = true;
  start_job(v, host, measure_at, pixel);
}

void action::follow_measures(Viewer& v, Host& host) {
  PointMeasures& measuring = v.measures;
  if (measures_are_to_keep(v)) keep_measures(v, host, {});
  const bool shows_view = v.shown.version == v.version && v.shown.divisor == 1 && v.still();
  if (!shows_view || !v.panels.measures || measuring.points() < 2 || v.levels ||
      measuring.asked_version == v.view_version)
    return;
  measuring.asked_version = v.view_version;
  host.run_behind([v](RenderContext& context) { look_behind(context, v); });
}

void action::measure_selection(Viewer& v, Host& host) {
  const auto selected = v.editing.selected;
  if (!selected) return notify(v, "select Gaussians first (Shift+B)");
  if (v.levels) return notify(v, "a selection in a tree that is not read whole has no known box");
  v.measures.busy = true;
  const glm::dmat3 level = glm::mat3_cast(v.measures.ground ? level_turn(v.measures.ground->up)
                                                            : glm::dquat(1, 0, 0, 0));
  host.run([selected, level](RenderContext& context) {
    MeasuredBox box{selected->count()};
    const AtEnd end{[&] { context.report(action::box_measured, box); }};
    GaussianCloud centres;
    const GaussianCloud& cloud = context.session.scene->cloud;
    selected->for_each([&](std::size_t i) {
      if (i < cloud.size()) centres.positions.emplace_back(level * glm::dvec3(cloud.positions[i]));
    });
    box.all = glm::dvec3(scene_box(centres).size());
    box.core = glm::dvec3(core_box(centres).size());
  });
}

}  // namespace qs
