// SPDX-License-Identifier: MIT
#include "app/session/page_edits.h"

#include <algorithm>
#include <cmath>
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

bool needs_whole_scene(const EditStep& step) {
  if (step.kind == EditKind::floaters) return true;
  if (step.kind != EditKind::select) return false;
  const SelectTool tool = step.select.tool;
  return tool == SelectTool::list || tool == SelectTool::flood || tool == SelectTool::grow ||
         tool == SelectTool::shrink ||
         (draws_in_picture(tool) && step.select.kind != SelectKind::through);
}

// ---- borders -----------------------------------------------------------------------------------

struct Ball {
  glm::dvec3 center;
  double radius;
};

bool is_near(double value, double limit, const Ball& ball) {
  return std::abs(value - limit) <= ball.radius;
}

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
  if (step.kind == EditKind::crop)
    return [box = step.box](const Ball& ball) { return has_border(box, ball); };
  if (step.kind != EditKind::select) return {};
  const SelectStep& select = step.select;
  if (draws_in_picture(select.tool))
    return [shape = shape_of(select), camera = select.camera.placed(origin)](const Ball& ball) {
      return has_border(shape, camera, ball);
    };
  if (select.tool == SelectTool::box)
    return [box = select.box](const Ball& ball) { return has_border(box, ball); };
  const ValueRange range =
      select.tool == SelectTool::sphere ? ValueRange{0, select.radius} : select.range;
  if (select.tool == SelectTool::sphere || select.tool == SelectTool::distance)
    return [range, point = select.point, normal = select.normal](const Ball& ball) {
      const glm::dvec3 offset = ball.center - point;
      const double value = normal ? glm::dot(offset, glm::normalize(*normal)) : glm::length(offset);
      return is_near(value, range.low, ball) || is_near(value, range.high, ball);
    };
  return {};
}

}  // namespace

std::function<void(LodPage&)> page_editor(std::vector<EditStep> steps, const std::string& source,
                                          float footprint) {
  constexpr double kRounding = 1.0001;
  bool knows_leaves = footprint > 0;  // of merged nodes
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (needs_whole_scene(steps[i]))
      fail(
          ErrorKind::usage,
          "{}: step {} needs the whole scene, and a tree that is not read whole has only crops and "
          "selections by sphere, box, distance, opacity, size, color and shapes with the kind "
          "through",
          source, i + 1);
    steps[i].select.count.reset();  // of leaves
    steps[i].select.crc.clear();
    knows_leaves = knows_leaves && !is_of_values(steps[i]);
  }
  return [=](LodPage& page) {
    ThreadPool alone(1);
    EditState state(page.cloud.size());
    std::vector<std::function<bool(const Ball&)>> borders;
    for (const EditStep& step : steps) {
      carry_out(step, {page.cloud, alone, {}, set_hash}, source, state);
      if (auto border = border_of(step, page.cloud.origin)) borders.push_back(std::move(border));
    }
    const GaussianSet rest = state.rest();
    for (std::size_t row = 0; row < page.nodes.size(); ++row) {
      LodFacts& node = page.nodes[row];
      const Ball ball{page.cloud.positions[row], kRounding * static_cast<double>(node.radius)};
      if (node.child_count > 0 && footprint > 0 &&
          std::ranges::any_of(borders, [&](const auto& border) { return border(ball); })) {
        for (std::size_t k = 0; k < kLodFootprints && node.radius > lod_footprint(footprint, k);
             ++k)
          node.gains[k] = std::numeric_limits<std::uint8_t>::max();
      } else if (!rest[row] && knows_leaves) {
        node.child_count = 0;
      }
      if (rest[row]) continue;
      page.cloud.opacity_logits[row] = -std::numeric_limits<float>::infinity();
      node.layers = node.opacities = 0;
    }
  };
}

}  // namespace qs
