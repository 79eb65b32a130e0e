// SPDX-License-Identifier: MIT
//
// The panels of the scene, its cameras, its crop and its training.
#include <cmath>

#include <fmt/format.h>

#include "app/viewer/panel_model/panel_model.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/charts.h"
#include "app/viewer/state/crop_actions.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/training_actions.h"

namespace qs {

block::Controls in_line(std::vector<block::Placed> controls) {
  for (std::size_t i = 1; i < controls.size(); ++i) controls[i].follows = true;
  return {std::move(controls)};
}

block::Controls fields(float width, std::vector<std::string> names) {
  block::Controls controls;
  for (std::string& name : names) controls.controls.push_back({std::move(name), width});
  return controls;
}

Blocks settings_blocks(const Viewer& v) {
  Blocks blocks = {block::Facts{scene_facts_of(v)}, block::Line{},
                   fields(9, {"SH degree", "splat scale", "style", "background", "antialias",
                              "backend", "pipeline", "leave out what is larger than the scene"})};
  // The window has them in its menus and in the legend over the picture.
  if (v.is_remote)
    blocks.emplace_back(
        fields(9, {"Heat map", "opacity over the colours", "colour map", "Picture of",
                   "Draw smaller while moving (CPU)", "Leave out hidden Gaussians (GPU)"}));
  return blocks;
}

// ---- crop and clean ----------------------------------------------------------------------------
Blocks crop_blocks(const Viewer& v) {
  constexpr float kField = -7;
  block::Controls box = fields(kField, {"Box"});
  for (const char* axis : {"x right", "y down", "z forward"})
    box.controls.push_back({.name = axis,
                            .width = kField,
                            .form = block::Form::range,
                            .speed = 0.002 * v.scene->extent()});
  block::Controls floaters =
      fields(kField, {"faint", "opacity", "large", "of the core", "isolated", "neighbours"});
  floaters.indented = true;
  block::Controls selecting =
      fields(kField, {"Select with", "how", "selects", "weight", "brush", "tolerance"});
  block::Controls values;
  for (const std::string value : {"opacity", "size", "distance"}) {
    values.controls.push_back(
        {.name = "by " + value, .width = -12, .form = block::Form::range, .speed = 0.001});
    values.controls.push_back(
        {.name = "Select by " + value, .follows = true, .short_label = "Select"});
  }
  return {box,
          in_line({{"Fit"}, {"Show all"}}),
          fields(kField, {"Floaters"}),
          floaters,
          in_line({{"Apply"}}),
          block::Line{},
          selecting,
          in_line({{"All"}, {"Nothing"}, {"Invert"}, {"Grow"}, {"Shrink"}, {"Same colour"}}),
          in_line({{"Remove"}, {"Keep only"}, {"Hide"}, {"Show hidden"}}),
          block::Text{crop_text(v)},
          in_line({{"Undo"}, {"Redo"}, {"Save the edits"}, {"Save the cropped scene"}}),
          block::Local::crop_file,
          block::Line{},
          values,
          fields(0, {"Tint what goes"})};
}

// ---- measuring ---------------------------------------------------------------------------------
Blocks measure_blocks(const Viewer& v) {
  block::Facts facts;
  for (const MeasureRow& row : rows_of_measures(v))
    facts.facts.push_back(
        {row.name, row.more.empty() ? row.value : fmt::format("{}\n{}", row.value, row.more)});
  return {in_line({{"Set points"}, {"New line"}, {"Second view"}}),
          std::move(facts),
          in_line({{"Copy"}, {"Save the measures"}, {"Remove the last point"}, {"Clear"}}),
          block::Line{},
          fields(-7, {"known length", "unit"}),
          block::Text{scale_preview(v), Tone::faint},
          in_line({{"Set the scale"}, {"Set the ground"}, {"Measure the selection"}})};
}

// ---- cameras and the path ----------------------------------------------------------------------
namespace {

std::vector<block::Item> keyframe_items(const Viewer& v, std::size_t i) {
  std::vector<block::Item> items = {{ControlKind::button, "remove keyframe", "x"},
                                    {ControlKind::item, "keyframe", keyframe_label(v, i)}};
  if (i > 0)
    items.push_back({ControlKind::number, "seconds", "seconds after the keyframe before",
                     v.keyframes[i].time - v.keyframes[i - 1].time, 0.05, 3600});
  items.push_back({ControlKind::toggle, "ease", "ease", v.keyframes[i].eases ? 1.0 : 0.0});
  return items;
}

block::Chart chart_of(const IterationChart& from, const char* title) {
  block::Chart chart{.title = title, .axis = kIterationTitle, .letters = 10};
  for (const AxisTick& tick : from.iteration_ticks)
    chart.across.push_back({static_cast<float>(tick.value / from.most_iteration), tick.text});
  for (const AxisTick& tick : from.value_ticks)
    chart.up.push_back({static_cast<float>(from.share(tick.value)), tick.text});
  return chart;
}

block::Chart loss_curve(const Viewer& v) {
  const std::vector<LossPoint>& losses = v.training->losses;
  const IterationChart from = loss_chart(losses);
  block::Chart chart = chart_of(from, kLossTitle);
  block::Curve curve{.ink = {kSkyBlue, kBlue}, .is_marked = false, .width = 1.5f};
  for (const LossPoint& point : losses)
    if (std::isfinite(point.loss))
      curve.points.push_back(
          {point.iteration / from.most_iteration, from.share(static_cast<double>(point.loss))});
  chart.curves.push_back(std::move(curve));
  if (v.is_remote) return chart;  // hundreds of readings would be sent again with every report
  chart.reading = [&losses, most = from.most_iteration](double x) {
    const LossPoint& near = loss_near(losses, x * most);
    return block::Reading{near.iteration / most,
                          fmt::format("iteration {}: loss {:.4f}", near.iteration, near.loss),
                          {}};
  };
  return chart;
}

block::Chart psnr_curves(const TrainingProgress& progress) {
  std::vector<PsnrPoint> all = progress.test_psnrs;
  all.insert(all.end(), progress.reserved_psnrs.begin(), progress.reserved_psnrs.end());
  const IterationChart from = psnr_chart(all);
  block::Chart chart = chart_of(from, progress.reserved_psnrs.empty()
                                          ? "PSNR on the test views, dB"
                                          : "PSNR, dB: test views; dashed: reserved views");
  for (const std::vector<PsnrPoint>* points : {&progress.reserved_psnrs, &progress.test_psnrs}) {
    block::Curve curve{.ink = {kSkyBlue, kBlue},
                       .is_dashed = points == &progress.reserved_psnrs,
                       .is_marked = false,
                       .width = 1.5f};
    for (const PsnrPoint& point : *points)
      curve.points.push_back({point.iteration / from.most_iteration, from.share(point.psnr)});
    chart.curves.push_back(std::move(curve));
  }
  return chart;
}

}  // namespace

Blocks camera_blocks(const Viewer& v) {
  Blocks blocks;
  const ViewedScene& scene = *v.scene;
  if (scene.cameras.empty()) {
    std::string text = "This scene came without cameras.";
    if (!v.is_remote)
      text += " Drop its cameras.json, transforms.json or COLMAP folder on the window.";
    blocks.push_back(block::Text{text});
  } else {
    block::List list{scene.cameras.size(),
                     [&scene](std::size_t i) { return camera_label(scene, i); },
                     {},
                     "camera"};
    if (v.dataset_camera >= 0) list.chosen = static_cast<std::size_t>(v.dataset_camera);
    blocks.emplace_back(std::move(list));
    blocks.push_back(in_line({{"in the scene"}, {"photograph"}}));
    blocks.push_back(fields(10, {"opacity of the photograph"}));
  }
  blocks.push_back(block::Line{});
  blocks.push_back(block::Text{
      fmt::format("Path: {} keyframe{}", v.keyframes.size(), v.keyframes.size() == 1 ? "" : "s"),
      Tone::faint});
  block::Items keyframes;
  for (std::size_t i = 0; i < v.keyframes.size(); ++i)
    keyframes.rows.push_back(keyframe_items(v, i));
  blocks.emplace_back(std::move(keyframes));
  blocks.push_back(in_line({{"Set here"}, {"Film"}, {"Play"}, {"Save"}, {"loop"}}));
  blocks.push_back(
      block::Controls{{{.name = "time", .width = block::kWholeLine, .short_label = ""}}});
  blocks.push_back(block::Line{});
  block::Items bookmarks;
  for (const auto& [name, camera] : bookmarks_of(v))
    bookmarks.rows.push_back(
        {{ControlKind::button, "remove bookmark", "x"}, {ControlKind::item, "bookmark", name}});
  // The window's own has fields for the names.
  blocks.push_back(v.is_remote ? Block(bookmarks) : block::Local::bookmarks);
  blocks.push_back(in_line({{"Bookmark"}}));
  return blocks;
}

// ---- training ----------------------------------------------------------------------------------

Blocks training_blocks(const Viewer& v) {
  if (v.remote) return {in_line({{"Pause training"}}), block::Facts{remote_facts(v)}};
  if (!v.training)
    return {block::Text{"Nothing is trained. File > Train from photographs starts a run."}};
  const TrainingProgress& progress = v.training->progress;
  const double share =
      progress.iterations > 0 ? static_cast<double>(progress.iteration) / progress.iterations : 0;
  Blocks blocks = {block::Progress{"Iterations done", share},
                   in_line({{"Pause training"}, {"Step"}, {"Save the model"}, {"Stop training"}}),
                   block::Local::test_view, block::Facts{training_facts(v)}};
  if (progress.test_psnrs.size() > 1 || progress.reserved_psnrs.size() > 1)
    blocks.emplace_back(psnr_curves(progress));
  if (v.training->losses.size() > 1) blocks.emplace_back(loss_curve(v));
  return blocks;
}

}  // namespace qs
