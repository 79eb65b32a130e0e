// SPDX-License-Identifier: MIT
//
// Jobs of editing: the steps one after the other, and the file of edits.
#include <exception>
#include <memory>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "app/session/page_edits.h"
#include "app/session/scene_edits.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/render/measured_view.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/edit_actions.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/select_actions.h"
#include "base/fail.h"
#include "base/text.h"
#include "io/bytes/replace_file.h"
#include "raster/select/by_shape.h"
#include "raster/select/by_value.h"
#include "raster/select/editing.h"

namespace qs {
namespace {

// Steps that begin at a pixel: a sphere around the surface there, through another pixel, and the
// base colour of the Gaussian that makes the surface.
void find_at_pixel(RenderContext& context, SelectStep& step) {
  if (step.pixels.empty() || (step.tool != SelectTool::sphere && step.tool != SelectTool::color))
    return;
  const Camera camera = step.camera.placed(context.session.scene->cloud.origin);
  const MeasuredView view(context, camera);
  const auto point = view.surface(step.pixels[0]);
  if (!point) fail("no surface is here: more than half of the light passes");
  if (step.tool == SelectTool::color) {
    step.color = glm::clamp(base_srgb(*view.drawn.cloud, point->gaussian), 0.0, 1.0);
  } else {
    const double depth = (camera.view_from_world * glm::dvec4(point->position, 1)).z;
    step.point = point->position;
    step.radius = depth * glm::length((step.pixels[1] - step.pixels[0]) / step.camera.focal_px);
  }
  step.pixels.clear();
}

// A selection in a tree that is not read whole is of leaves: visible and touching Gaussians become
// the list of the drawn leaves. Returns a sentence about the others.
std::string list_leaves(RenderContext& context, SelectStep& step) {
  if (!needs_frame(step)) return {};
  const Session& session = context.session;
  if (!session.scene->levels->has_originals)
    fail(ErrorKind::usage,
         "the leaves of this tree have no numbers, which quadsplat lod --original keeps: select "
         "through");
  const Camera camera = step.camera.placed(session.scene->cloud.origin);
  Outputs outputs{.color = false};
  outputs.seen = pixels_in(shape_of(step), {camera.width, camera.height},
                           step.kind == SelectKind::touching ? 0 : step.weight, *session.pool);
  const DrawnView drawn = draw_view(session, camera, outputs, context.stop);
  GaussianSet leaves(session.scene->levels->nodes);
  drawn.frame.seen.for_each([&](std::size_t i) {
    if (drawn.numbers[i] < leaves.size()) leaves.add(std::size_t{drawn.numbers[i]});
  });
  const std::size_t merged = drawn.frame.seen.count() - leaves.count();
  step = {.tool = SelectTool::list, .how = step.how, .members = leaves.runs()};
  return fmt::format("{} of the drawn leaves selected{}", grouped(leaves.count()),
                     merged == 0 ? ""
                                 : fmt::format("; {} coarser nodes are not: come closer to select "
                                               "their leaves, or select through",
                                               grouped(merged)));
}

// Checks a step of a tree that is not read whole; show_crop() carries it out.
void check_step(RenderContext& context, EditStep& step) {
  const Scene& tree = *context.session.scene;
  if (tree.edits.steps > 0)
    fail(ErrorKind::usage,
         "{} was opened with --edits: open it without, then open the file of edits here",
         tree.path.filename().string());
  find_at_pixel(context, step.select);
  const std::string sentence = list_leaves(context, step.select);
  page_editor({step}, "edit", tree);
  context.report(action::step_done, step, std::make_shared<const EditState>());
  if (!sentence.empty()) context.report(action::notify, sentence);
}

void carry_out_step(RenderContext& context, EditStep step, const EditState& before) {
  Session& session = context.session;
  const GaussianCloud& cloud = session.scene->cloud;
  auto after = std::make_shared<EditState>(
      before.removed.size() == cloud.size() ? before : EditState(cloud.size()));
  const EditTools tools{
      cloud,
      *session.pool,
      // The rest is in the window.
      [&](const GaussianSet&, const Camera& camera, const Shape& shape, float weight) {
        return seen_by(*session.renderer, cloud, camera, shape, weight, *session.pool,
                       context.stop);
      },
      set_hash,
      {{}, context.stop}};
  try {
    if (session.scene->stream) return check_step(context, step);
    find_at_pixel(context, step.select);
    carry_out(step, tools, "edit", *after);
    if (step.kind == EditKind::select) note_result(*after, set_hash, step.select);
    context.report(action::step_done, step, std::shared_ptr<const EditState>(after));
  } catch (const Cancelled&) {
    context.report(action::step_failed, std::string("the step was cancelled"));
  } catch (const std::bad_alloc&) {
    context.report(action::step_failed, std::string("there is not enough memory to edit"));
  } catch (const std::exception& error) {
    context.report(action::step_failed, std::string(error.what()));
  }
}

// The steps, and for convert the scale and the level that were measured.
std::vector<EditStep> saved_steps(const Viewer& v) {
  std::vector<EditStep> steps = v.editing.history.steps();
  const MeasureScale& scale = v.measures.scale;
  if (!scale.unit.empty())
    steps.push_back({.kind = EditKind::scale, .factor = scale.factor, .unit = scale.unit});
  if (v.measures.ground)
    steps.push_back({.kind = EditKind::level, .rotation = level_turn(v.measures.ground->up)});
  return steps;
}

void write_edits(RenderContext& context, const Viewer& viewer) {
  const Scene& whole = *context.session.scene;
  const OutputFile output(viewer, "", viewer.scene->name, ".edits.json");
  const EditsFile file = edits_file(whole, saved_steps(viewer), true);
  write_text(output.path(), format_edits(file, whole.cloud.origin));
  output.done(context, fmt::format(" ({})", counted(file.steps.size(), "step")));
  context.report(action::edits_saved);
}

void read_edits_file(RenderContext& context, const EditOptions& options) {
  const std::filesystem::path& path = *options.file;
  const Scene& whole = *context.session.scene;
  try {
    if (whole.edits.steps > 0)
      fail(ErrorKind::usage,
           "{}: edits are of a whole file, but this scene was opened without some of its Gaussians",
           path.string());
    EditHistory history(whole.stream ? 0 : whole.cloud.size());
    if (whole.stream) {
      const EditsFile file = edits_of_tree(whole, options);
      page_editor(file.steps, path.string(), whole);  // refuses what it cannot do
      for (const EditStep& step : file.steps) history.take(step, EditState());
    } else {
      edited(whole, options, *context.session.pool,
             [&](const EditStep& step, const EditState& state) { history.take(step, state); });
    }
    context.report(action::edits_opened, path, history);
  } catch (const std::exception& error) {
    context.report(action::step_failed, std::string(error.what()));
  }
}

}  // namespace

void action::follow_edits(Viewer& v, Host& host) {
  const CropRequest wanted = wanted_crop(v);
  if (v.crop.busy || v.editing.busy) return;
  if (wanted != v.crop.asked) {
    v.crop.busy = true;
    v.crop.asked = wanted;
    host.run(show_crop(wanted));
  } else if (!v.editing.waiting.empty()) {
    v.editing.busy = true;
    const EditStep step = v.editing.waiting.front();
    v.editing.waiting.pop_front();
    host.run([step, before = v.editing.history.shared_state()](RenderContext& context) {
      carry_out_step(context, step, *before);
    });
  } else if (edits_are_to_keep(v)) {
    // Files of large selections take long, so they are written between the strokes of a brush.
    constexpr std::size_t kSmall = std::size_t{1} << 20;
    constexpr double kRestSeconds = 1;
    if (v.editing.history.memory() < kSmall || v.now - v.editing.changed > kRestSeconds)
      keep_edits(v, host, {});
  }
}

void action::keep_edits(Viewer& v, Host& host, const Action& then) {
  v.editing.kept = true;
  const auto text = [history = v.editing.history](const Scene& scene) {
    return history.has_steps()
               ? format_edits(edits_file(scene, history.steps(), false), scene.cloud.origin)
               : std::string();
  };
  keep_beside(v, host, {".edits.json", "edits", v.editing.owns_file, text, edits_kept}, then);
}

void action::open_edits(Viewer& v, Host& host, const std::filesystem::path& file,
                        const std::optional<std::string>& text) {
  if (!v.scene || v.editing.busy) return;
  v.editing.busy = true;
  v.editing.waiting.clear();
  host.run([=](RenderContext& context) { read_edits_file(context, {file, text}); });
}

void action::use_cross(Viewer& v, Host& host) {
  const bool is_new = v.cross && !std::exchange(v.cross_is_used, true);
  if (v.measures.picks) return is_new ? measure_pixel(v, host, *v.cross) : end_line(v);
  is_new ? use_cross_to_select(v) : close_shape(v);
}

void action::save_edits(Viewer& viewer, Host& host) {
  if (!viewer.scene) return;
  if (saved_steps(viewer).empty()) return notify(viewer, "there is no edit to save");
  start_job(viewer, host, write_edits);
}

}  // namespace qs
