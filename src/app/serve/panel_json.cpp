// SPDX-License-Identifier: MIT
#include "app/serve/panel_json.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "app/inspect/frame_canvas.h"
#include "app/picture/grid_places.h"
#include "app/picture/palette.h"
#include "app/serve/served_commands.h"
#include "app/viewer/commands/controls.h"
#include "app/viewer/commands/keys.h"
#include "app/viewer/state/crop_actions.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/loss_chart.h"
#include "app/viewer/state/mode_glance.h"
#include "app/viewer/state/mode_table.h"
#include "app/viewer/state/panel_text.h"
#include "app/viewer/state/training_actions.h"
#include "app/viewer/state/zoom_chart.h"
#include "app/viewer/state/zoom_text.h"

namespace qs {
namespace {

using Json = nlohmann::json;

// ---- panels and controls -----------------------------------------------------------------------
struct PanelName {
  const char* name;  ///< for the page
  bool Panels::*panel;
};

// In the order of the page.
constexpr PanelName kPanels[] = {
    {"table", &Panels::hud},           {"split", &Panels::split},
    {"inspector", &Panels::inspector}, {"recorder", &Panels::recorder},
    {"crop", &Panels::crop},           {"path", &Panels::cameras},
    {"settings", &Panels::info},       {"training", &Panels::training}};

constexpr const char* kKinds[] = {"toggle", "choice", "number", "color", "button", "item"};

Json panels_json(const Viewer& v) {
  Json rows = Json::array();
  for (const PanelName& panel : kPanels) {
    if (panel.panel == &Panels::training && !v.training) continue;
    const auto served = served_commands();
    const auto command = std::find_if(served.begin(), served.end(), [&](const KeyCommand* row) {
      return row->panel == panel.panel;
    });
    if (command == served.end()) continue;
    rows.push_back({{"name", panel.name},
                    {"title", (*command)->help},
                    {"key", key_name((*command)->key, (*command)->mods)},
                    {"open", v.panels.*panel.panel}});
  }
  return rows;
}

Json control_json(const Control& control, const ControlNow& now) {
  Json row = {{"name", control.name},
              {"label", label_of(control, now)},
              {"kind", kKinds[static_cast<int>(control.kind)]},
              {"value", now.value},
              {"help", control.help},
              {"enabled", now.is_enabled}};
  if (control.kind == ControlKind::number) {
    row["least"] = now.least;
    row["most"] = now.most;
    row["step"] = now.step;
    row["log"] = now.is_logarithmic;
    row["typed"] = now.is_typed;
    row["decimals"] = now.decimals;
    row["unit"] = now.unit;
  }
  if (control.kind == ControlKind::choice) row["choices"] = now.choices;
  return row;
}

Json controls_json(const Viewer& v) {
  Json by_panel = Json::object();
  for (const PanelName& panel : kPanels) {
    if (!(v.panels.*panel.panel)) continue;
    Json rows = Json::array();
    for (const Control& control : controls()) {
      if (control.panel != panel.panel || control.kind == ControlKind::item) continue;
      if (const auto now = control_now(v, control)) rows.push_back(control_json(control, *now));
    }
    by_panel[panel.name] = rows;
  }
  return by_panel;
}

Json facts_json(const std::vector<Fact>& facts) {
  Json rows = Json::array();
  for (const Fact& fact : facts) rows.push_back({fact.label, fact.value});
  return rows;
}

// ---- the table of modes ------------------------------------------------------------------------
Json cell_json(const Viewer& v, const HudRow& row, const TableColumn& column) {
  const bool noisy = column.noisy != nullptr && row.*column.noisy;
  const bool live = column.value == &HudRow::pairs_value && row.pairs_live;
  const bool sampled = column.kind == CellKind::bar && row.fps_sampled;
  const bool trusted = live || sampled || (numbers_are_current(v) && !noisy);
  const std::string text = column.kind == CellKind::mode ? row.name
                           : column.text == nullptr      ? ""
                                                         : row.*column.text;
  return {{"text", text}, {"faint", !trusted}};
}

Json stages_json(const Viewer& v, CullMode mode) {
  const BenchRow* row = measured_row(v, mode, v.settings.pipeline);
  if (row == nullptr) return nullptr;
  return {{"ms", stages_of(*row)}, {"text", stages_text(*row)}};
}

constexpr const char* kWaitingForATurn =
    "not measured yet: the renderer still draws pictures, and the visitors take turns";

Json table_json(const Visitor& visitor) {
  const Viewer& v = visitor.viewer();
  const std::vector<TableColumn> columns = table_columns(v);
  Json titles = Json::array(), rows = Json::array();
  constexpr const char* kCells[] = {"mode", "bar", "number", "stages"};
  for (const TableColumn& column : columns)
    titles.push_back({{"title", column.title},
                      {"kind", kCells[static_cast<int>(column.kind)]},
                      {"rank", column.rank},
                      {"letters", column.letters}});
  for (const HudRow& row : hud_rows(v)) {
    Json cells = Json::array(), values = Json::array();
    for (const TableColumn& column : columns) {
      cells.push_back(cell_json(v, row, column));
      values.push_back(column.value == nullptr ? Json() : Json(row.*column.value));
    }
    rows.push_back({{"mode", row.name},
                    {"number", row.mode},
                    {"cells", cells},
                    {"values", values},
                    {"fps", row.fps_value},
                    {"low", row.fps_low},
                    {"high", row.fps_high},
                    {"trust", trust_text(v, row.mode)},
                    {"stages", stages_json(v, row.mode)}});
  }
  const bool waits = visitor.measuring() == Measuring::waits && !numbers_are_current(v);
  const std::string caveat = hud_caveat(v);
  return {{"columns", titles},
          {"rows", rows},
          {"mode", mode_name(v.mode())},
          {"status", waits ? kWaitingForATurn : hud_status(v)},
          {"waits", waits},
          {"measuring", visitor.measuring() == Measuring::runs},
          {"caption", table_caption(v)},
          {"facts", facts_json(hud_facts(v))},
          {"caveat", caveat.empty() ? "" : "this frame: " + caveat}};
}

// ---- the picture -------------------------------------------------------------------------------
Json ticks_json(const Legend& legend) {
  Json ticks = Json::array(), colors = Json::array();
  for (const BarTick& tick : legend.ticks) ticks.push_back({tick.at, tick.text});
  constexpr int kColors = 33;
  for (int i = 0; i < kColors; ++i)
    colors.push_back(hex_text(legend.color(static_cast<float>(i) / (kColors - 1))));
  return {{"title", legend.title}, {"ticks", ticks}, {"colors", colors}};
}

Json split_json(const Viewer& v) {
  const ShownFrame& shown = v.shown;
  if (!v.panels.split || v.shows_grid || !shown.other) return nullptr;
  Json json = {{"names", split_names(v)},
               {"view", kSplitViews[static_cast<int>(v.split.view)]},
               {"sides", v.split.view == SplitView::sides},
               {"divider", v.split.divider},
               {"facts", facts_json(split_facts(v))},
               {"words", ""}};
  if (v.split.view == SplitView::difference)
    json["legend"] = ticks_json(difference_legend(shown_amplification(v)));
  if (v.split.view == SplitView::tile_pairs && shown.other->pairs) {
    json["legend"] = ticks_json(pair_legend(shown));
    json["words"] = kPairColors;
  }
  const bool has_maps = v.split.view == SplitView::sides || v.split.view == SplitView::whole;
  if (has_maps && shown.heatmap && shown.other->heatmap) json["words"] = heat_facts(v);
  return json;
}

Json grid_json(const Viewer& v) {
  if (!v.shown.grid) return nullptr;
  const GridPlaces places = grid_places(culler_count(), kGridLabel);
  Json labels = Json::array();
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const glm::vec2 low = places.low(mode - 1);
    labels.push_back({{"mode", mode_name(mode)},
                      {"text", grid_label(v, mode)},
                      {"x", low.x},
                      {"y", low.y},
                      {"here", mode == v.mode()}});
  }
  Json json = {{"labels", labels}, {"side", places.side}, {"columns", places.columns}};
  if (v.shown.heatmap) json["legend"] = ticks_json(heat_legend(v));
  return json;
}

// ---- the inspector -----------------------------------------------------------------------------
constexpr std::size_t kMostContributions = 300;

Json contribution_json(const Inspection& inspection, const Contribution& row, bool stops) {
  return {{"gaussian", row.gaussian},
          {"label", contribution_label(row, stops)},
          {"cells", contribution_cells(row, stops)},
          {"color", hex_text(glm::clamp(row.color, 0.0f, 1.0f))},
          {"transmittance", row.transmittance},
          {"stops", stops},
          {"picked", inspection.gaussian && inspection.gaussian->gaussian == row.gaussian}};
}

Json box_json(const Box& box) { return {box.low.x, box.low.y, box.high.x, box.high.y}; }

Json boxes_json(const std::vector<Box>& boxes) {
  Json rows = Json::array();
  for (const Box& box : boxes) rows.push_back(box_json(box));
  return rows;
}

// The shape of a Gaussian with the boxes and tiles of the modes, in pixels of the frame.
Json construction_json(const InspectedView& view, CullMode mode) {
  constexpr std::size_t kMostTiles = 2000;
  const GaussianReport& gaussian = *view.inspection.gaussian;
  const CullMode drawn = inspected_mode(mode);
  const auto index = static_cast<std::size_t>(drawn - 1);
  const ModeTiles& listed = gaussian.modes[index];
  Json tiles = Json::array(), ellipse = Json::array(), counts = Json::array();
  for (std::size_t i = 0; i < std::min(listed.tiles.size(), kMostTiles); ++i) {
    const auto use = static_cast<int>(view.inspection.uses[index][i]);
    tiles.push_back({box_json(box_of_tile(view.grid, listed.tiles[i])), use});
  }
  for (std::size_t i = 0; i < gaussian.modes.size(); ++i) {
    const PairUses uses = uses_of(view.inspection, i);
    counts.push_back({{"mode", mode_name(gaussian.modes[i].mode)},
                      {"here", gaussian.modes[i].mode == drawn},
                      {"counts", {uses.pairs(), uses.used, uses.hidden, uses.empty}}});
  }
  Json boxes = Json::array();
  const auto add = [&](CullMode of, const std::vector<Box>& those) {
    boxes.push_back({{"mode", mode_name(of)}, {"boxes", boxes_json(those)}});
  };
  add(k3dgs, {gaussian.square});
  if (gaussian.visible) {
    add(kAdr, {gaussian.adr});
    add(kQuad, gaussian.quad_boxes);
    add(kDual, gaussian.dual_boxes);
    for (const glm::vec2 point : ellipse_of(gaussian.footprint, 64))
      ellipse.push_back({point.x, point.y});
  }
  return {{"window", box_json(window_of(gaussian, view.grid))},
          {"side", view.grid.tile_px},
          {"mode", mode_name(drawn)},
          {"tiles", tiles},
          {"boxes", boxes},
          {"ellipse", ellipse},
          {"words", construction_text(mode)},
          {"columns", kTileColumns},
          {"counts", counts}};
}

Json inspector_json(const Viewer& v) {
  if (!v.panels.inspector) return nullptr;
  if (!v.inspected) return {{"words", kNothingInspected}};
  const Inspection& inspection = v.inspected->inspection;
  const PixelReport& pixel = inspection.pixel;
  Json rows = Json::array();
  for (const Contribution& row : pixel.contributions) {
    if (rows.size() >= kMostContributions) break;
    rows.push_back(contribution_json(inspection, row, false));
  }
  const std::size_t left = pixel.contributions.size() - rows.size();
  if (pixel.stopped_by) rows.push_back(contribution_json(inspection, *pixel.stopped_by, true));
  const bool current = v.inspected->version == v.version;
  Json json = {{"words", inspected_pixel_text(pixel)},
               {"note", current ? "" : kInspectedEarlier},
               {"pixel", {pixel.pixel.x, pixel.pixel.y}},
               {"current", current},
               {"columns", kContributionColumns},
               {"rows", rows},
               {"more", left},
               {"behind", pixel.transmittance},
               {"title", kTransmittanceTitle}};
  if (inspection.gaussian) json["construction"] = construction_json(*v.inspected, v.mode());
  return json;
}

// ---- the zoom recorder -------------------------------------------------------------------------
Json axis_json(const std::vector<AxisTick>& ticks, const ZoomChart& chart, bool across) {
  Json rows = Json::array();
  for (const AxisTick& tick : ticks) {
    const glm::dvec2 at = across ? chart.place(tick.value, 0) : chart.place(1, tick.value);
    rows.push_back({across ? at.x : at.y, tick.text});
  }
  return rows;
}

// Points as shares of the chart's width and height, with the values at the cursor.
Json chart_json(const ZoomChart& chart) {
  Json curves = Json::array(), readings = Json::array();
  for (const ZoomCurve& curve : chart.curves) {
    Json points = Json::array();
    for (const ZoomPoint& point : curve.points) {
      const glm::dvec2 at = chart.place(point.zoom, point.value);
      points.push_back({at.x, at.y, chart.place(1, point.low).y, chart.place(1, point.high).y});
    }
    curves.push_back({{"mode", mode_name(curve.mode)},
                      {"dashed", curve.is_beneath},
                      {"band", curve.is_banded},
                      {"points", points}});
  }
  if (!chart.empty()) {
    for (const ZoomPoint& point : chart.curves.back().points) {
      const double x = chart.place(point.zoom, 0).x;
      const auto reading = read_zoom_chart(chart, x);
      if (!reading) continue;
      Json rows = Json::array();
      for (const ZoomReading::Row& row : reading->rows)
        rows.push_back({mode_name(row.mode), row.value});
      readings.push_back({{"at", x}, {"title", reading->title}, {"rows", rows}});
    }
  }
  return {{"title", chart.title},
          {"axis", kZoomAxis},
          {"across", axis_json(chart.zoom_ticks, chart, true)},
          {"up", axis_json(chart.value_ticks, chart, false)},
          {"curves", curves},
          {"readings", readings}};
}

Json recorder_json(const Viewer& v) {
  if (!v.panels.recorder) return nullptr;
  const ZoomRecorder& zoom = v.zoom;
  const ZoomRecord* record = shown_zoom(zoom);
  Json json = {{"running", zoom.running},
               {"plan", zoom_plan_text(v)},
               {"start", zoom_start_text(zoom.plan)},
               {"status", zoom_status(zoom)}};
  if (record == nullptr) return json;
  json["label"] = zoom_label(*record);
  json["trust"] = zoom_trust_text(*record);
  const ZoomChart chart = zoom_chart(record, zoom_beneath(zoom), zoom.quantity);
  if (!chart.empty()) json["chart"] = chart_json(chart);
  return json;
}

// ---- crop, cameras, the rest -------------------------------------------------------------------
Json crop_json(const Viewer& v) {
  if (!v.panels.crop) return nullptr;
  Json json = {{"words", crop_text(v)}};
  if (!v.crop.wish.boxed || v.crop.applied) return json;
  const Camera& camera = v.camera;
  // Shares of the picture's width and height.
  const auto place = [&](glm::dvec2 pixel) {
    constexpr double kMost = 1e4;
    const glm::dvec2 share = (pixel + 0.5) / glm::dvec2(camera.width, camera.height);
    return Json{std::clamp(share.x, -kMost, kMost), std::clamp(share.y, -kMost, kMost)};
  };
  json["lines"] = Json::array();
  for (const PictureLine& line : box_lines(camera, v.crop.wish.box))
    json["lines"].push_back({place(line.from), place(line.to)});
  json["handles"] = Json::array();
  for (int face = 0; face < kBoxFaces; ++face) {
    const auto pixel = handle_in_picture(camera, v.crop.wish.box, face);
    json["handles"].push_back(pixel ? place(*pixel) : Json());
  }
  return json;
}

Json path_json(const Viewer& v) {
  if (!v.panels.cameras) return nullptr;
  constexpr std::size_t kMostCameras = 2000;
  Json cameras = Json::array(), keyframes = Json::array();
  for (std::size_t i = 0; i < std::min(v.scene->cameras.size(), kMostCameras); ++i)
    cameras.push_back(camera_label(*v.scene, i));
  for (std::size_t i = 0; i < v.keyframes.size(); ++i) {
    const double before = i > 0 ? v.keyframes[i - 1].time : v.keyframes[i].time;
    keyframes.push_back({{"label", keyframe_label(v, i)},
                         {"ease", v.keyframes[i].eases},
                         {"seconds", v.keyframes[i].time - before}});
  }
  return {{"cameras", cameras}, {"camera", v.dataset_camera}, {"keyframes", keyframes}};
}

// The facts without the file, whose value is a path.
Json scene_json(const Viewer& v) {
  if (!v.panels.info) return nullptr;
  std::vector<Fact> facts = scene_facts_of(v);
  std::erase_if(facts, [](const Fact& fact) { return fact.label == "file"; });
  return facts_json(facts);
}

// The curve of the loss, as shares of the chart's width and height.
Json loss_json(const std::vector<LossPoint>& losses) {
  const LossChart chart = loss_chart(losses);
  Json across = Json::array(), up = Json::array(), points = Json::array();
  for (const AxisTick& tick : chart.iteration_ticks)
    across.push_back({tick.value / chart.most_iteration, tick.text});
  for (const AxisTick& tick : chart.loss_ticks)
    up.push_back({tick.value / chart.most_loss, tick.text});
  for (const LossPoint& point : losses) {
    const double loss = static_cast<double>(point.loss);
    if (std::isfinite(loss))
      points.push_back({point.iteration / chart.most_iteration, loss / chart.most_loss});
  }
  Json curve = {{"mode", ""}, {"dashed", false}, {"plain", true}, {"band", false}};
  curve["points"] = points;
  return {{"title", kLossTitle}, {"axis", kIterationTitle},  {"across", across}, {"up", up},
          {"curves", {curve}},   {"readings", Json::array()}};
}

// Without the folder of the model.
Json training_json(const Viewer& v) {
  if (!v.panels.training || !v.training) return nullptr;
  const TrainingProgress& progress = v.training->progress;
  Json facts = Json::array();
  for (const Fact& fact : training_facts(v)) {
    if (fact.label == "model") continue;
    facts.push_back({fact.label == "in the window" ? "in the picture" : fact.label,
                     public_text(v, fact.value)});
  }
  Json json = {{"facts", facts},
               {"share", progress.iterations > 0
                             ? static_cast<double>(progress.iteration) / progress.iterations
                             : 0.0}};
  if (v.training->losses.size() > 1) json["chart"] = loss_json(v.training->losses);
  return json;
}

Json job_json(const Viewer& v) {
  if (v.zoom.running)
    return {{"words", "recording a zoom: " + zoom_status(v.zoom)}, {"share", nullptr}};
  if (v.zoom.starting)
    return {{"words", "recording a zoom: waits for its turn"}, {"share", nullptr}};
  if (!v.loading) return nullptr;
  return {{"words", v.loading->what}, {"share", v.loading->fraction}};
}

Json status_json(const Viewer& v) {
  const StatusLine line = status_line(v);
  return {{"numbers", line.numbers},
          {"note", line.note},
          {"faint", line.faint},
          {"caution", line.caution}};
}

}  // namespace

Json panel_sections(const Visitor& visitor) {
  const Viewer& v = visitor.viewer();
  return {{"panels", panels_json(v)},
          {"controls", controls_json(v)},
          {"table", v.panels.hud ? table_json(visitor) : Json()},
          {"split", split_json(v)},
          {"grid", grid_json(v)},
          {"inspector", inspector_json(v)},
          {"recorder", recorder_json(v)},
          {"crop", crop_json(v)},
          {"path", path_json(v)},
          {"facts", scene_json(v)},
          {"training", training_json(v)},
          {"job", job_json(v)},
          {"status", status_json(v)}};
}

Json legend_json() {
  Json modes = Json::object(), stages = Json::array();
  for (CullMode mode = 1; mode <= mode_count(); ++mode)
    modes[mode_name(mode)] = {{"dark", hex_text(on_dark::mode_color(mode))},
                              {"light", hex_text(mode_color(mode))},
                              {"summary", row_of(mode).summary}};
  for (std::size_t stage = 0; stage < kStageCount; ++stage)
    stages.push_back({{"name", kStageNames[stage]},
                      {"dark", hex_text(on_dark::kStages[stage])},
                      {"light", hex_text(on_white::kStages[stage])}});
  return {{"modes", modes}, {"stages", stages}};
}

std::string public_text(const Viewer& v, std::string text) {
  const std::string path = v.scene ? v.scene->path.string() : "";
  for (std::size_t at = path.empty() ? text.npos : text.find(path); at != text.npos;
       at = text.find(path, at + v.scene->name.size()))
    text.replace(at, path.size(), v.scene->name);
  constexpr std::string_view kBounds = " \t\n\"'(),:;";
  std::string result;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of(kBounds, begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const std::size_t slash = word.find_last_of('/');
    const bool is_path = word.size() > 1 && slash != word.npos &&
                         (word.starts_with('/') || word.starts_with('.') || word.starts_with('~'));
    result += is_path ? word.substr(slash + 1) : word;
    if (end < text.size()) result += text[end];
    begin = end + 1;
  }
  return result;
}

}  // namespace qs
