// SPDX-License-Identifier: MIT
//
// Jobs of selecting: the Gaussians under a tool, and the file of edits.
#include <exception>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "app/session/scene_edits.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/kept_work.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/select_actions.h"
#include "base/fail.h"
#include "io/bytes/replace_file.h"
#include "raster/select/editing.h"

namespace qs {
namespace {

// The scene in the window has all Gaussians that can be selected: tints do not move them.
void select_step(RenderContext& context, const SelectStep& step,
                 const std::shared_ptr<const GaussianSet>& before) {
  Session& session = context.session;
  const GaussianCloud& cloud = session.scene->cloud;
  EditState state(cloud.size());
  if (before && before->size() == cloud.size()) state.selected = *before;
  const EditTools tools{
      cloud,
      *session.pool,
      [&](const GaussianSet&, const Camera& camera, const Shape& shape, float weight) {
        return seen_in_whole(*session.renderer, cloud, camera, shape, weight, *session.pool,
                             context.stop);
      },
      set_hash,
      {{}, context.stop}};
  try {
    carry_out({.select = step}, tools, "select", state);
    context.report(action::gaussians_selected,
                   std::make_shared<const GaussianSet>(std::move(state.selected)));
  } catch (const Cancelled&) {
    context.report(action::selecting_failed, std::string("selecting was cancelled"));
  } catch (const std::exception& error) {
    context.report(action::selecting_failed, std::string(error.what()));
  }
}

void run_selection(Viewer& viewer, Host& host, const SelectStep& step) {
  if (viewer.selecting.busy) return;
  viewer.selecting.busy = true;
  host.run([step, before = selection_of(viewer)](RenderContext& context) {
    select_step(context, step, before);
  });
}

// The steps of the crops, on the whole scene, and of a selection that was not applied.
EditsFile edits_of(const Scene& whole, const std::vector<CropWish>& wishes,
                   const std::shared_ptr<const GaussianSet>& selected, ThreadPool& pool) {
  EditsFile file{edited_scene(whole), {}};
  EditState state(whole.cloud.size());
  const EditTools tools{whole.cloud, pool, {}, set_hash};
  const auto add = [&](EditStep step) {
    carry_out(step, tools, "edits", state);
    if (step.kind == EditKind::select) step.select.count = state.selected.count();
    file.steps.push_back(std::move(step));
  };
  const auto add_selected = [&](const GaussianSet& set, const std::vector<std::uint32_t>& numbers) {
    GaussianSet in_file(whole.cloud.size());
    set.for_each([&](std::size_t i) { in_file.add(numbers[i]); });
    add({.select = {.tool = SelectTool::list, .members = in_file.runs()}});
  };
  for (const CropWish& wish : wishes) {
    const std::vector<std::uint32_t> numbers = state.rest().numbers();
    if (wish.boxed) add({.kind = EditKind::crop, .box = wish.box});
    if (wish.cleans) add({.kind = EditKind::floaters, .floaters = wish.floaters});
    if (!wish.selected || wish.selected->size() != numbers.size()) continue;
    add_selected(*wish.selected, numbers);
    add({.kind = EditKind::remove});
  }
  const std::vector<std::uint32_t> numbers = state.rest().numbers();
  if (selected && selected->size() == numbers.size()) add_selected(*selected, numbers);
  return file;
}

void write_edits(RenderContext& context, const Viewer& viewer) {
  const std::shared_ptr<const Scene> whole =
      context.cropped ? context.cropped->whole : context.session.scene;
  if (whole->edits.steps > 0)
    fail(ErrorKind::usage,
         "edits are of a whole file, but this scene was opened without some of its Gaussians: save "
         "the cropped scene");
  const OutputFile output(viewer, "", viewer.scene->name, ".edits.json");
  const EditsFile file =
      edits_of(*whole, applied_wishes(viewer.crop), selection_of(viewer), *context.session.pool);
  write_text(output.path(), format_edits(file, whole->cloud.origin));
  output.done(context, fmt::format(" ({} steps)", file.steps.size()));
  context.report(action::edits_saved);
}

}  // namespace

void action::end_shape(Viewer& viewer, Host& host) {
  if (!viewer.selecting.tool || viewer.selecting.drawn.empty() || !viewer.scene) return;
  const bool is_click = viewer.selecting.drawn.size() < 2;
  const bool is_brush = *viewer.selecting.tool == SelectTool::brush;
  if (!is_click || is_brush) run_selection(viewer, host, drawn_step(viewer));
  viewer.selecting.drawn.clear();
}

void action::use_cross(Viewer& v, Host& host) {
  const bool is_new = v.cross && !std::exchange(v.cross_is_used, true);
  if (v.measures.picks) return is_new ? measure_pixel(v, host, *v.cross) : end_line(v);
}

void action::select_by(Viewer& viewer, Host& host, SelectTool tool) {
  if (!viewer.scene) return;
  SelectStep step;
  step.tool = tool;
  step.tolerance = static_cast<double>(viewer.selecting.tolerance);
  run_selection(viewer, host, step);
}

void action::save_edits(Viewer& viewer, Host& host) {
  if (!viewer.scene) return;
  if (applied_wishes(viewer.crop).empty() && !selection_of(viewer))
    return notify(viewer, "there is no edit to save");
  start_job(viewer, host, write_edits);
}

}  // namespace qs
