// SPDX-License-Identifier: MIT
#include "app/viewer/state/state_json.h"

#include <nlohmann/json.hpp>

#include "app/inspect/inspection_text.h"
#include "app/viewer/state/hud_text.h"
#include "io/camera/cameras.h"

namespace qs {

std::string state_json(const Viewer& viewer) {
  using nlohmann::ordered_json;
  ordered_json json;
  json["scene"] = viewer.scene ? viewer.scene->name : "";
  json["gaussians"] = viewer.scene ? viewer.scene->gaussians : 0;
  json["mode"] = mode_name(viewer.mode());
  json["backend"] = kBackendNames[static_cast<int>(viewer.backend)];
  json["pipeline"] = kPipelineNames[static_cast<int>(viewer.settings.pipeline)];
  json["camera"] = viewer.camera.width > 0 && viewer.scene
                       ? ordered_json::parse(format_camera(viewer.camera))
                       : ordered_json();
  json["axes"] = viewer.scene ? viewer.scene->axes : "";
  json["dataset_camera"] = viewer.dataset_camera;
  json["divisor"] = viewer.shown.divisor;
  json["interop"] = viewer.shown.interop;
  json["present_ms"] = {{"into_gl", viewer.shown.stats.present_ms}, {"draw", viewer.present_ms}};
  json["caveat"] = hud_caveat(viewer);
  json["numbers_are_current"] = numbers_are_current(viewer);
  for (const HudRow& row : hud_rows(viewer)) {
    json["modes"].push_back({{"mode", row.name},
                             {"ms", row.ms},
                             {"fps", row.fps},
                             {"pairs", row.pairs},
                             {"per_visible", row.per_visible},
                             {"unused", row.unused},
                             {"speedup", row.speedup},
                             {"other_ms", row.other_ms},
                             {"other_speedup", row.other_speedup}});
  }
  for (const Fact& fact : hud_facts(viewer)) json["facts"][fact.label] = fact.value;
  if (viewer.shown.heatmap) {
    json["heatmap"] = {{"quantity", heatmap_row(viewer.shown.heatmap->quantity).name},
                       {"total", viewer.shown.heatmap->total}};
    if (viewer.shown.missed) json["heatmap"]["missed"] = missed_sentence(*viewer.shown.missed);
  }
  if (viewer.shown.other) {
    const PixelBox& region = viewer.shown.other->region;
    json["split"] = {{"first", full_name(viewer.variant())},
                     {"other", full_name(viewer.shown.other->variant)},
                     {"view", kSplitViews[static_cast<int>(viewer.split.view)]},
                     {"divider", viewer.split.divider},
                     {"flipped", viewer.split.flipped},
                     {"region", {region.x0, region.y0, region.x1, region.y1}}};
    for (const Fact& fact : split_facts(viewer)) json["split"][fact.label] = fact.value;
  }
  if (viewer.inspected) json["inspector"] = inspection_json(viewer.inspected->inspection);
  if (viewer.comparison) json["oracle"] = viewer.comparison->sentence;
  json["toasts"] = ordered_json::array();
  for (const Toast& toast : viewer.toasts) json["toasts"].push_back(toast.text);
  json["keyframes"] = viewer.keyframes.size();
  json["zoom"] = {{"running", viewer.zoom.running},
                  {"rows", viewer.zoom.rows.size()},
                  {"folder", viewer.zoom.folder.string()}};
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace qs
