// SPDX-License-Identifier: MIT
#include "app/viewer/state/zoom_recorder.h"

#include <algorithm>
#include <cmath>

#include "app/measure/measure_view.h"
#include "app/measure/scene_facts.h"
#include "app/session/session.h"

namespace qs {
namespace {

bool is_same_camera(const std::optional<Camera>& a, const std::optional<Camera>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->view_from_world == b->view_from_world && a->width == b->width && a->height == b->height;
}

}  // namespace

bool ZoomPlan::operator==(const ZoomPlan& other) const {
  return is_same_camera(start, other.start) && closer == other.closer && steps == other.steps &&
         frames == other.frames && modes == other.modes && size == other.size &&
         pipeline == other.pipeline;
}

ZoomPlan clamped_plan(ZoomPlan plan, Backend backend) {
  const double closer = std::isfinite(plan.closer) ? plan.closer : ZoomPlan().closer;
  plan.closer = std::clamp(closer, kLeastCloser, kMostCloser);
  plan.steps = std::clamp(plan.steps, kFewestZoomSteps, kMostZoomSteps);
  plan.frames = std::clamp(plan.frames, kFewestZoomFrames, kMostZoomFrames);
  std::ranges::sort(plan.modes);
  plan.modes.erase(std::unique(plan.modes.begin(), plan.modes.end()), plan.modes.end());
  std::erase_if(plan.modes, [](CullMode mode) { return mode < 1 || mode > culler_count(); });
  if (plan.modes == all_modes()) plan.modes.clear();
  if (plan.size.x < 1 || plan.size.y < 1) plan.size = {0, 0};
  plan.size.x = std::min(plan.size.x, kMostZoomSide);
  plan.size.y = std::min(plan.size.y, kMostZoomSide);
  const std::span<const Pipeline> pipelines = pipelines_of(backend);
  if (plan.pipeline && (pipelines.size() < 2 || std::ranges::count(pipelines, *plan.pipeline) == 0))
    plan.pipeline.reset();
  return plan;
}

std::vector<CullMode> zoom_modes(const ZoomPlan& plan) {
  return plan.modes.empty() ? all_modes() : plan.modes;
}

Camera zoom_start(const ZoomPlan& plan, const Camera& view) {
  const glm::ivec2 size = plan.size.x > 0 ? plan.size : glm::ivec2(view.width, view.height);
  return plan.start.value_or(view).resized(size.x, size.y);
}

int zoom_frames(const ZoomPlan& plan, Backend backend) {
  constexpr int kCountingFrames = 1;  // of the false positives
  const int marked = backend == Backend::cpu ? 0 : std::min(plan.frames, kMarkedFrames);
  return kZoomWarmUp + plan.frames + marked + kCountingFrames;
}

ZoomRecord make_zoom_record(const ZoomBundle& bundle) {
  return {.scene = scene_name(bundle.scene),
          .machine = measured_on(bundle.environment),
          .pipeline = bundle.environment.value("pipeline", ""),
          .width = bundle.start.width,
          .height = bundle.start.height,
          .steps = bundle.steps,
          .closest = bundle.closest,
          .modes = bundle.modes,
          .rows = bundle.rows};
}

const ZoomRecord* shown_zoom(const ZoomRecorder& zoom) {
  return zoom.shown && *zoom.shown < zoom.records.size() ? &zoom.records[*zoom.shown] : nullptr;
}

const ZoomRecord* zoom_beneath(const ZoomRecorder& zoom) {
  return zoom.beneath && *zoom.beneath < zoom.records.size() ? &zoom.records[*zoom.beneath]
                                                             : nullptr;
}

void forget_zoom_views(ZoomRecorder& zoom) {
  zoom.plan.start.reset();
  zoom.shown.reset();
  zoom.beneath.reset();
}

}  // namespace qs
