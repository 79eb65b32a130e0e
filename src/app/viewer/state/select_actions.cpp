// SPDX-License-Identifier: MIT
#include "app/viewer/state/select_actions.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "app/viewer/state/actions.h"
#include "app/viewer/state/edit_actions.h"

namespace qs {
namespace {

constexpr double kLeastStep = 2;    // pixels between the points of a stroke
constexpr double kClosePixels = 8;  // around the first corner of a polygon

std::vector<PictureLine> lines_through(const std::vector<glm::dvec2>& points, bool closes) {
  std::vector<PictureLine> lines;
  for (std::size_t i = 1; i < points.size(); ++i) lines.push_back({points[i - 1], points[i]});
  if (closes && points.size() > 2) lines.push_back({points.back(), points.front()});
  return lines;
}

std::vector<PictureLine> circle(glm::dvec2 center, double radius) {
  constexpr int kSides = 32;
  std::vector<glm::dvec2> points;
  for (int side = 0; side < kSides; ++side) {
    const double angle = 2 * std::acos(-1.0) * side / kSides;
    points.push_back(center + radius * glm::dvec2(std::cos(angle), std::sin(angle)));
  }
  return lines_through(points, true);
}

void add_corner(Selecting& selecting, glm::dvec2 pixel) {
  constexpr std::size_t kMost = 4096;
  if (selecting.drawn.size() < kMost) selecting.drawn.push_back(pixel);
}

// The tools with a first and a last point.
bool has_two_points(SelectTool tool) {
  return tool == SelectTool::rectangle || tool == SelectTool::sphere;
}

}  // namespace

std::vector<PictureLine> shape_lines(const Viewer& v) {
  const Selecting& selecting = v.selecting;
  if (!selecting.tool || !v.scene) return {};
  const std::vector<glm::dvec2>& drawn = selecting.drawn;
  switch (*selecting.tool) {
    case SelectTool::polygon:
    case SelectTool::lasso:
      return lines_through(drawn, true);
    case SelectTool::brush: {
      std::vector<PictureLine> lines = lines_through(drawn, false);
      const auto around =
          circle(v.cross.value_or(v.cursor), static_cast<double>(selecting.brush_px));
      lines.insert(lines.end(), around.begin(), around.end());
      return lines;
    }
    default:
      break;
  }
  if (drawn.size() < 2) return {};
  const glm::dvec2 a = drawn.front(), b = drawn.back();
  if (*selecting.tool == SelectTool::sphere) return circle(a, glm::distance(a, b));
  return lines_through({a, {b.x, a.y}, b, {a.x, b.y}}, true);
}

SelectStep drawn_step(const Viewer& v) {
  const Selecting& selecting = v.selecting;
  SelectStep step;
  step.tool = selecting.tool.value_or(SelectTool::rectangle);
  step.how = selecting.how;
  step.kind = selecting.kind;
  step.weight = selecting.weight;
  step.camera = v.camera;
  if (v.scene) step.camera.origin = v.scene->origin;
  step.pixels = selecting.drawn;
  if (has_two_points(step.tool)) step.pixels = {step.pixels.front(), step.pixels.back()};
  step.radius = static_cast<double>(selecting.brush_px);
  step.tolerance = static_cast<double>(selecting.tolerance);
  return step;
}

namespace action {

void choose_tool(Viewer& v, const std::optional<SelectTool>& tool) {
  if (!v.scene) return;
  v.selecting.tool = tool;
  v.selecting.drawn.clear();
  if (!tool) return;
  v.measures.picks = false;
  v.panels.crop = true;
  const char* const gesture = *tool == SelectTool::polygon ? "clicks set corners, Enter closes"
                              : *tool == SelectTool::color ? "a click selects"
                                                           : "drag selects";
  notify(v, fmt::format("{}: {}, Shift adds, Ctrl takes away; the right button turns the view, "
                        "Escape ends",
                        kSelectToolNames[static_cast<std::size_t>(*tool)], gesture));
}

void next_tool(Viewer& v) {
  const auto here = v.selecting.tool ? std::ranges::find(kPictureTools, *v.selecting.tool)
                                     : std::end(kPictureTools);
  if (here == std::end(kPictureTools)) return choose_tool(v, kPictureTools[0]);
  const auto next = std::next(here);
  choose_tool(v, next == std::end(kPictureTools) ? std::nullopt : std::optional(*next));
}

void scale_brush(Viewer& v, float factor) {
  v.selecting.brush_px = std::clamp(v.selecting.brush_px * factor, 1.0f, 2000.0f);
}

void begin_shape(Viewer& v, glm::dvec2 pixel, SelectHow how) {
  if (!v.selecting.tool) return;
  if (v.settings.lens)
    return notify(v, "shapes select in the picture of a pinhole camera (Shift+5)");
  Selecting& selecting = v.selecting;
  if (*selecting.tool == SelectTool::polygon && !selecting.drawn.empty())
    return add_corner(selecting, pixel);
  selecting.drawn = {pixel};
  selecting.how = how == SelectHow::replace ? selecting.way : how;
}

void extend_shape(Viewer& v, glm::dvec2 pixel) {
  std::vector<glm::dvec2>& drawn = v.selecting.drawn;
  if (drawn.empty() || glm::distance(drawn.back(), pixel) < kLeastStep) return;
  const SelectTool tool = *v.selecting.tool;
  if (has_two_points(tool)) drawn.resize(1);
  if (tool == SelectTool::polygon) drawn.pop_back();  // the drag moves the corner
  if (tool != SelectTool::color) add_corner(v.selecting, pixel);
}

void end_shape(Viewer& v) {
  std::vector<glm::dvec2>& drawn = v.selecting.drawn;
  if (!v.selecting.tool || drawn.empty()) return;
  const SelectTool tool = *v.selecting.tool;
  if (tool == SelectTool::polygon) {
    if (drawn.size() < 4 || glm::distance(drawn.front(), drawn.back()) > kClosePixels) return;
    drawn.pop_back();  // the first corner closes it
  } else if (drawn.size() < 2 && tool != SelectTool::brush && tool != SelectTool::color) {
    return drawn.clear();
  }
  close_shape(v);
}

void close_shape(Viewer& v) {
  std::vector<glm::dvec2>& drawn = v.selecting.drawn;
  if (!v.selecting.tool || drawn.empty()) return;
  const SelectTool tool = *v.selecting.tool;
  const std::size_t least = tool == SelectTool::polygon || tool == SelectTool::lasso ? 3
                            : has_two_points(tool)                                   ? 2
                                                                                     : 1;
  if (drawn.size() < least)
    return notify(v, fmt::format("a {} needs {} points",
                                 kSelectToolNames[static_cast<std::size_t>(tool)], least));
  edit(v, {.select = drawn_step(v)});
  drawn.clear();
}

void cancel_tool(Viewer& v) {
  v.cross.reset();
  v.measures.picks = false;
  if (v.selecting.drawn.empty()) v.selecting.tool.reset();
  v.selecting.drawn.clear();
}

void use_cross_to_select(Viewer& v) {
  if (!v.selecting.tool) return;
  const SelectTool tool = *v.selecting.tool;
  std::vector<glm::dvec2>& drawn = v.selecting.drawn;
  if (drawn.empty() || tool == SelectTool::polygon) {
    begin_shape(v, *v.cross, SelectHow::replace);
  } else {
    extend_shape(v, *v.cross);
  }
  if (tool == SelectTool::color || (has_two_points(tool) && drawn.size() == 2)) close_shape(v);
}

void select_by_value(Viewer& v, SelectTool tool) {
  SelectStep step{.tool = tool, .how = v.selecting.way};
  step.range = tool == SelectTool::opacity ? v.selecting.opacity
               : tool == SelectTool::size  ? v.selecting.size
                                           : v.selecting.distance;
  const SurfacePoint* const point = v.measures.last_point();
  if (tool == SelectTool::distance && point == nullptr)
    return notify(v, "measure a point first (Shift+M): distances are from the last one");
  if (point != nullptr) step.point = point->position;
  edit(v, {.select = step});
}

void select_by(Viewer& v, SelectTool tool) {
  edit(v, {.select = {.tool = tool, .tolerance = static_cast<double>(v.selecting.tolerance)}});
}

}  // namespace action
}  // namespace qs
