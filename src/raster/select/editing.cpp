// SPDX-License-Identifier: MIT
#include "raster/select/editing.h"

#include <utility>

#include "base/fail.h"
#include "base/text.h"
#include "raster/select/by_shape.h"
#include "raster/select/by_value.h"

namespace qs {
namespace {

GaussianSet met_in_picture(const SelectStep& step, const EditTools& tools,
                           const GaussianSet& rest) {
  const Shape shape = shape_of(step);
  if (step.kind == SelectKind::through)
    return gaussians_through(tools.cloud, step.camera, shape, tools.pool);
  return tools.seen(rest, step.camera, shape,
                    step.kind == SelectKind::visible ? step.weight : 0.0f);
}

// The Gaussians of the step's list, which must be ascending runs of the scene.
GaussianSet listed(const SelectStep& step, const std::string& where, std::size_t size) {
  GaussianSet set(size);
  std::uint64_t end = 0;
  for (const GaussianRun& run : *step.members) {
    if (run.count == 0 || run.first < end || run.count > size || run.first > size - run.count)
      fail("{}: members {} + {} are no ascending run of {} Gaussians", where, run.first, run.count,
           grouped(size));
    end = run.first + run.count;
    for (std::uint64_t i = run.first; i < end; ++i) set.add(static_cast<std::size_t>(i));
  }
  return set;
}

// The Gaussians that the tool finds; of tools that change the selection, the new selection.
GaussianSet found(const SelectStep& step, const EditTools& tools, const std::string& where,
                  const GaussianSet& selected, const GaussianSet& rest) {
  const GaussianCloud& cloud = tools.cloud;
  ThreadPool& pool = tools.pool;
  switch (step.tool) {
    case SelectTool::rectangle:
    case SelectTool::polygon:
    case SelectTool::lasso:
    case SelectTool::brush:
      return met_in_picture(step, tools, rest);
    case SelectTool::sphere:
      return gaussians_at_distance(cloud, step.point, {}, {0, step.radius}, pool);
    case SelectTool::box:
      return GaussianSet::where(
          cloud.size(), pool, [&](std::size_t i) { return step.box.contains(cloud.positions[i]); });
    case SelectTool::color:
      return gaussians_of_color(cloud, step.color, step.tolerance, pool);
    case SelectTool::opacity:
      return gaussians_of_opacity(cloud, step.range, pool);
    case SelectTool::size:
      return gaussians_of_size(cloud, step.range, pool);
    case SelectTool::distance:
      return gaussians_at_distance(cloud, step.point, step.normal, step.range, pool);
    case SelectTool::list:
      return listed(step, where, cloud.size());
    case SelectTool::flood:
      return flooded(cloud, selected, rest, step.tolerance, pool);
    case SelectTool::grow:
      return grown(cloud, selected, rest, step.steps, pool);
    case SelectTool::shrink:
      return shrunk(cloud, selected, rest, step.steps, pool);
    case SelectTool::invert:
      return selected.complement();
    case SelectTool::all:
      return rest;
    case SelectTool::none:
      break;
  }
  return GaussianSet(cloud.size());
}

// The difference between the step's count or hash and its selection; empty if they agree.
std::string difference(const SelectStep& step, const GaussianSet& selected, const SetHash& hash) {
  const std::size_t count = selected.count();
  if (step.count && *step.count != count)
    return fmt::format("it selects {} in place of {} Gaussians", grouped(count),
                       grouped(*step.count));
  if (!step.crc.empty() && step.crc != hash(selected))
    return fmt::format("it selects {} other Gaussians than it did", grouped(count));
  return {};
}

GaussianSet combined(SelectHow how, GaussianSet selected, const GaussianSet& with) {
  switch (how) {
    case SelectHow::replace:
      return with;
    case SelectHow::add:
      return selected |= with;
    case SelectHow::take_away:
      return selected -= with;
    case SelectHow::common:
      return selected &= with;
  }
  return selected;
}

std::string select_by(const SelectStep& step, const EditTools& tools, const std::string& where,
                      EditState& state) {
  const GaussianSet rest = state.rest();
  const auto computed = [&] {
    GaussianSet tool = found(step, tools, where, state.selected, rest);
    return changes_selection(step.tool) ? tool : combined(step.how, state.selected, tool);
  };
  const bool has_result = step.members && step.tool != SelectTool::list;
  GaussianSet selected =
      has_result && !tools.recomputes ? listed(step, where, tools.cloud.size()) : computed();
  selected &= rest;
  const std::string differs = difference(step, selected, tools.hash);
  state.selected = std::move(selected);
  if (differs.empty()) return {};
  if (!tools.recomputes) fail("{}: {}", where, differs);
  return fmt::format("{}: {}", where, differs);
}

void remove_all(EditState& state, const GaussianSet& gone) {
  state.removed |= gone;
  state.selected -= state.removed;
  state.hidden -= state.removed;
}

GaussianSet removed_by(const EditStep& step, const EditTools& tools, const GaussianSet& rest) {
  const Removal removal = find_removal(
      tools.cloud, step.kind == EditKind::crop ? std::optional(step.box) : std::nullopt,
      step.kind == EditKind::floaters ? std::optional(step.floaters) : std::nullopt, tools.progress,
      &rest);
  return removal.gone(tools.pool);
}

}  // namespace

Shape shape_of(const SelectStep& step) {
  if (step.tool == SelectTool::brush) return Shape::stroke(step.pixels, step.radius);
  if (step.tool == SelectTool::rectangle && step.pixels.size() == 2)
    return Shape::rectangle(step.pixels[0], step.pixels[1]);
  return Shape::polygon(step.pixels);
}

GaussianSet seen_by(Renderer& renderer, const GaussianCloud& cloud, const Camera& camera,
                    const Shape& shape, float weight, ThreadPool& pool, std::stop_token stop) {
  Outputs outputs{.color = false};
  outputs.seen = pixels_in(shape, {camera.width, camera.height}, weight, pool);
  return renderer.render(camera.placed(cloud.origin), {}, outputs, HostImage{}, std::move(stop))
      .seen;
}

SeenInPicture seen_with(Renderer& renderer, std::shared_ptr<const GaussianCloud> cloud,
                        ThreadPool& pool, bool has_cloud, std::stop_token stop) {
  return
      [&renderer, &pool, cloud = std::move(cloud), stop, has_cloud, drawn = GaussianSet()](
          const GaussianSet& rest, const Camera& camera, const Shape& shape, float weight) mutable {
        if (!has_cloud) renderer.upload(cloud, {{}, stop});
        has_cloud = true;
        if (drawn != rest) renderer.set_drawn(rest);
        drawn = rest;
        return seen_by(renderer, *cloud, camera, shape, weight, pool, stop);
      };
}

std::string carry_out(const EditStep& step, const EditTools& tools, const std::string& where,
                      EditState& state) {
  switch (step.kind) {
    case EditKind::select:
      return select_by(step.select, tools, where, state);
    case EditKind::hide:
      state.hidden |= std::exchange(state.selected, GaussianSet(tools.cloud.size()));
      break;
    case EditKind::show:
      state.hidden = GaussianSet(tools.cloud.size());
      break;
    case EditKind::remove:
      remove_all(state, GaussianSet(state.selected));
      break;
    case EditKind::keep:
      remove_all(state, state.rest() -= state.selected);
      state.selected = GaussianSet(tools.cloud.size());
      break;
    case EditKind::crop:
    case EditKind::floaters:
      remove_all(state, removed_by(step, tools, state.rest()));
      break;
    case EditKind::scale:
    case EditKind::level:
      break;
  }
  return {};
}

void note_result(const EditState& state, const SetHash& hash, SelectStep& step) {
  step.count = state.selected.count();
  step.crc = hash(state.selected);
  step.members.reset();
  if (needs_frame(step)) step.members = state.selected.runs();
}

}  // namespace qs
