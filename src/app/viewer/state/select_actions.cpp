// SPDX-License-Identifier: MIT
#include "app/viewer/state/select_actions.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "app/viewer/state/actions.h"
#include "base/text.h"

namespace qs {
namespace {

constexpr double kLeastStep = 2;  // pixels between the points of a stroke

std::vector<PictureLine> lines_through(const std::vector<glm::dvec2>& points, bool closes) {
  std::vector<PictureLine> lines;
  for (std::size_t i = 1; i < points.size(); ++i) lines.push_back({points[i - 1], points[i]});
  if (closes && points.size() > 2) lines.push_back({points.back(), points.front()});
  return lines;
}

}  // namespace

std::vector<PictureLine> shape_lines(const Viewer& v) {
  const Selecting& selecting = v.selecting;
  if (!selecting.tool || !v.scene) return {};
  const std::vector<glm::dvec2>& drawn = selecting.drawn;
  if (*selecting.tool == SelectTool::lasso) return lines_through(drawn, true);
  if (*selecting.tool == SelectTool::rectangle) {
    if (drawn.size() < 2) return {};
    const glm::dvec2 a = drawn.front(), b = drawn.back();
    return lines_through({a, {b.x, a.y}, b, {a.x, b.y}}, true);
  }
  std::vector<PictureLine> lines = lines_through(drawn, false);
  constexpr int kSides = 32;
  std::vector<glm::dvec2> circle;
  for (int side = 0; side < kSides; ++side) {
    const double angle = 2 * std::acos(-1.0) * side / kSides;
    circle.push_back(v.cursor + static_cast<double>(selecting.brush_px) *
                                    glm::dvec2(std::cos(angle), std::sin(angle)));
  }
  const std::vector<PictureLine> around = lines_through(circle, true);
  lines.insert(lines.end(), around.begin(), around.end());
  return lines;
}

std::shared_ptr<const GaussianSet> selection_of(const Viewer& v) {
  return v.crop.applied ? nullptr : v.crop.wish.selected;
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
  if (step.tool == SelectTool::rectangle) step.pixels = {step.pixels.front(), step.pixels.back()};
  step.radius = static_cast<double>(selecting.brush_px);
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
  notify(v, fmt::format("{}: drag selects, Shift adds, Ctrl takes away; the right button turns the "
                        "view, Escape ends",
                        kSelectToolNames[static_cast<std::size_t>(*tool)]));
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
  v.selecting.drawn = {pixel};
  v.selecting.how = how;
}

void extend_shape(Viewer& v, glm::dvec2 pixel) {
  std::vector<glm::dvec2>& drawn = v.selecting.drawn;
  if (drawn.empty() || glm::distance(drawn.back(), pixel) < kLeastStep) return;
  if (*v.selecting.tool == SelectTool::rectangle) drawn.resize(1);
  constexpr std::size_t kMost = 4096;
  if (drawn.size() < kMost) drawn.push_back(pixel);
}

void cancel_tool(Viewer& v) {
  v.cross.reset();
  v.measures.picks = false;
  if (v.selecting.drawn.empty()) v.selecting.tool.reset();
  v.selecting.drawn.clear();
}

void gaussians_selected(Viewer& v, const std::shared_ptr<const GaussianSet>& set) {
  v.selecting.busy = false;
  if (!v.scene) return;
  if (set->size() != v.scene->gaussians) return;  // the scene has changed meanwhile
  const std::size_t count = set->count();
  CropWish wish = v.crop.applied ? CropWish{} : v.crop.wish;
  wish.selected = count > 0 ? set : nullptr;
  if (v.crop.applied && !wish.selected) return notify(v, "no Gaussian is selected");
  change_crop(v, wish);
  v.selecting.saved = false;
  if (wish.selected) v.panels.crop = true;  // which shows it
  notify(v, count > 0 ? fmt::format("{} of {} selected; Delete removes them", grouped(count),
                                    counted(v.scene->gaussians, "Gaussian"))
                      : std::string("no Gaussian is selected"));
}

void selecting_failed(Viewer& v, const std::string& sentence) {
  v.selecting.busy = false;
  notify_error(v, sentence);
}

void edits_saved(Viewer& v) { v.selecting.saved = true; }

}  // namespace action
}  // namespace qs
