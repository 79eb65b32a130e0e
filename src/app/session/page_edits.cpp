// SPDX-License-Identifier: MIT
#include "app/session/page_edits.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/fail.h"
#include "io/cloud/edits.h"
#include "raster/select/editing.h"

namespace qs {
namespace {

bool is_of_values(const EditStep& step) {
  const SelectTool tool = step.select.tool;
  return step.kind == EditKind::select &&
         (tool == SelectTool::color || tool == SelectTool::opacity || tool == SelectTool::size);
}

bool needs_whole_scene(const EditStep& step, bool has_numbers) {
  if (step.kind == EditKind::floaters) return true;
  if (step.kind != EditKind::select || (step.select.members && has_numbers)) return false;
  const SelectTool tool = step.select.tool;
  return tool == SelectTool::list || tool == SelectTool::flood || tool == SelectTool::grow ||
         tool == SelectTool::shrink || needs_frame(step.select);
}

// The step with the leaves of its list as rows of a page.
EditStep step_on(const LodPage& page, EditStep step) {
  if (!step.select.members) return step;
  const std::vector<GaussianRun> all = std::exchange(*step.select.members, {});
  GaussianSet rows(page.numbers.size());
  for (std::size_t row = 0; row < page.numbers.size(); ++row) {
    const std::uint64_t number = page.numbers[row];
    const auto run = std::ranges::upper_bound(all, number, {}, &GaussianRun::first);
    if (number != kNoNumber && run != all.begin() &&
        number - std::prev(run)->first < std::prev(run)->count)
      rows.add(row);
  }
  step.select.members = rows.runs();
  return step;
}

bool takes_selection(EditKind kind) {
  return kind == EditKind::hide || kind == EditKind::remove || kind == EditKind::keep;
}

// True if the selection after the step depends on a list.
bool is_listed(const EditStep& step, bool before) {
  if (step.kind != EditKind::select) return before && !takes_selection(step.kind);
  const SelectTool tool = step.select.tool;
  const bool is_new = tool == SelectTool::all || tool == SelectTool::none ||
                      (!changes_selection(tool) && step.select.how == SelectHow::replace);
  return step.select.members || (before && !is_new);
}

// ---- borders -----------------------------------------------------------------------------------

struct Ball {
  glm::dvec3 center;
  double radius;
};

bool has_border(const CropBox& box, const Ball& ball) {
  const glm::dvec3 beyond =
      glm::max(glm::dvec3(box.low) - ball.center, ball.center - glm::dvec3(box.high));
  const double outside = glm::length(glm::max(beyond, 0.0));
  return outside > 0 ? outside <= ball.radius
                     : std::max({beyond.x, beyond.y, beyond.z}) >= -ball.radius;
}

// In the picture the ball is within a disc around its centre.
bool has_border(const Shape& shape, const Camera& camera, const Ball& ball) {
  const glm::dvec3 at = camera.view_from_world * glm::dvec4(ball.center, 1);
  if (at.z + ball.radius <= camera.near_depth) return false;
  if (at.z - ball.radius <= camera.near_depth) return true;
  const glm::dvec2 slope = glm::dvec2(at) / at.z;
  const double focal = std::max(camera.focal_px.x, camera.focal_px.y);
  const double disc =
      focal * ball.radius * std::sqrt(1 + glm::dot(slope, slope)) / (at.z - ball.radius);
  return shape.has_border_near(slope * camera.focal_px + camera.center_px, disc);
}

// A test of balls: true if both sides of the step's border may be in the ball.
std::function<bool(const Ball&)> border_of(const EditStep& step, const glm::dvec3& origin) {
  const SelectStep& select = step.select;
  const bool crops = step.kind == EditKind::crop;
  if (crops || (step.kind == EditKind::select && select.tool == SelectTool::box))
    return
        [box = crops ? step.box : select.box](const Ball& ball) { return has_border(box, ball); };
  if (step.kind != EditKind::select) return {};
  if (draws_in_picture(select.tool))
    return [shape = shape_of(select), camera = select.camera.placed(origin)](const Ball& ball) {
      return has_border(shape, camera, ball);
    };
  const ValueRange range =
      select.tool == SelectTool::sphere ? ValueRange{0, select.radius} : select.range;
  if (select.tool == SelectTool::sphere || select.tool == SelectTool::distance)
    return [range, point = select.point, normal = select.normal](const Ball& ball) {
      const glm::dvec3 offset = ball.center - point;
      const double value = normal ? glm::dot(offset, glm::normalize(*normal)) : glm::length(offset);
      return std::min(std::abs(value - range.low), std::abs(value - range.high)) <= ball.radius;
    };
  return {};
}

}  // namespace

PageEdit page_editor(std::vector<EditStep> steps, const std::string& source, const Scene& tree) {
  const float footprint = tree.stream->footprint();
  const bool has_numbers = tree.levels->has_originals;
  constexpr double kRounding = 1.0001;
  bool knows_leaves = footprint > 0;  // of merged nodes
  bool has_lists = false;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (needs_whole_scene(steps[i], has_numbers))
      fail(ErrorKind::usage,
           "{}: step {} needs the whole scene; a tree that is not read whole has crops, selections "
           "by sphere, box, distance, opacity, size, color and shapes with the kind through, and "
           "lists if its leaves have numbers (quadsplat lod --original)",
           source, i + 1);
    steps[i].select.count.reset();  // of leaves
    steps[i].select.crc.clear();
    knows_leaves = knows_leaves && !is_of_values(steps[i]);
    has_lists = has_lists || steps[i].select.members;
  }
  const auto shared = std::make_shared<const std::vector<EditStep>>(std::move(steps));
  return [=](LodPage& page) {
    ThreadPool alone(1);
    const EditTools tools{page.cloud, alone, {}, set_hash};
    EditState state(page.cloud.size()), own = state;  // own: of merged nodes, which no list has
    bool listed = false;
    std::vector<std::function<bool(const Ball&)>> borders;
    for (const EditStep& step : *shared) {
      const EditStep here = step_on(page, step);
      carry_out(here, tools, source, state);
      if (listed && takes_selection(step.kind)) {
        own.selected = GaussianSet(page.cloud.size());
      } else if (has_lists) {
        carry_out(here, tools, source, own);
      }
      listed = is_listed(step, listed);
      if (auto border = border_of(step, page.cloud.origin)) borders.push_back(std::move(border));
    }
    page.follows_leaves = has_lists;
    const GaussianSet leaves = state.rest(), merged = has_lists ? own.rest() : leaves;
    if (!state.selected.empty()) page.selected = std::move(state.selected);
    for (std::size_t row = 0; row < page.nodes.size(); ++row) {
      LodFacts& node = page.nodes[row];
      const Ball ball{page.cloud.positions[row], kRounding * static_cast<double>(node.radius)};
      const bool stays = node.child_count > 0 ? merged[row] : leaves[row];
      if (node.child_count > 0 && footprint > 0 &&
          std::ranges::any_of(borders, [&](const auto& border) { return border(ball); })) {
        open_first(node, footprint);
      } else if (!stays && knows_leaves) {
        node.child_count = 0;
      }
      if (stays) continue;
      page.cloud.opacity_logits[row] = -std::numeric_limits<float>::infinity();
      node.layers = node.opacities = 0;
    }
  };
}

}  // namespace qs
