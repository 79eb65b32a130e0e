// SPDX-License-Identifier: MIT
#include "app/viewer/state/zoom_recorder.h"

#include "app/measure/scene_facts.h"

namespace qs {

ZoomRecord make_zoom_record(const ZoomBundle& bundle) {
  ZoomRecord record;
  record.scene = scene_name(bundle.scene);
  record.machine = measured_on(bundle.environment);
  record.pipeline = bundle.environment.value("pipeline", "");
  record.width = bundle.start.width;
  record.height = bundle.start.height;
  record.steps = bundle.steps;
  record.closest = bundle.closest;
  record.modes = bundle.modes;
  record.rows = bundle.rows;
  return record;
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
