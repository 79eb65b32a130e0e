// SPDX-License-Identifier: MIT
#include "app/viewer/state/measure_actions.h"

#include <algorithm>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "base/path_kind.h"
#include "base/text.h"

namespace qs {
namespace {

std::string sides_text(glm::dvec3 sides, const MeasureScale& scale) {
  sides *= scale.factor;
  return fmt::format("{:.4g} x {:.4g} x {:.4g} {}", sides.x, sides.y, sides.z, scale.name());
}

std::string scale_text(const MeasureScale& scale) {
  return "1 unit = " + length_text(scale.factor, scale.factor * scale.error, scale.name());
}

// The last points of the line that grows, or of the line before it if it is new.
template <std::size_t Count>
std::optional<std::span<const SurfacePoint, Count>> last_points(const PointMeasures& measuring) {
  for (std::size_t i = measuring.lines.size(); i-- > 0;) {
    const auto& line = measuring.lines[i];
    if (line.size() >= Count) return std::span(line).template last<Count>();
    if (!line.empty()) break;
  }
  return std::nullopt;
}

std::optional<MeasureScale> typed_scale(const PointMeasures& measuring) {
  const auto ends = last_points<2>(measuring);
  if (!ends) return std::nullopt;
  return scale_of((*ends)[0], (*ends)[1], measuring.known, kLengthUnits[measuring.unit]);
}

}  // namespace

std::vector<Ruler> rulers_of(const Viewer& v) {
  const PointMeasures& measuring = v.measures;
  const bool is_known = measuring.hidden_version == v.view_version;
  std::vector<Ruler> rulers;
  for (const auto& line : measuring.lines)
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const MeasuredLength length = measured_leg(line[i], line[i + 1], measuring.scale).length;
      rulers.push_back({line[i],
                        line[i + 1],
                        {},
                        length_text(length.length, length.error, measuring.scale.name())});
    }
  for (std::size_t i = 0; is_known && i < std::min(rulers.size(), measuring.hidden.size()); ++i)
    rulers[i].hidden = measuring.hidden[i];
  return rulers;
}

std::vector<MeasureRow> rows_of_measures(const Viewer& v) {
  const PointMeasures& measuring = v.measures;
  const MeasureScale& scale = measuring.scale;
  std::vector<MeasureRow> rows;
  std::size_t number = 1;
  for (const auto& line : measuring.lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      const SurfacePoint& point = line[i];
      const glm::dvec3 at = point.position + v.scene->origin;
      rows.push_back({fmt::format("point {}", number + i),
                      fmt::format("({:.6g}, {:.6g}, {:.6g})", at.x, at.y, at.z),
                      point.is_soft() ? "soft surface" : ""});
      if (const auto& ground = measuring.ground)
        rows.back().more += fmt::format(
            "{}{} above the ground", point.is_soft() ? "; " : "",
            length_text(scale.factor * glm::dot(point.position - ground->point, ground->up),
                        scale.factor * point.along, scale.name()));
    }
    const auto more = measure_rows(line, number, scale, v.scene->up);
    rows.insert(rows.end(), more.begin(), more.end());
    number += line.size();
  }
  if (measuring.box)
    rows.push_back(
        {"selection", sides_text(measuring.box->all, scale),
         fmt::format("{}; middle 90 %: {}", counted(measuring.box->gaussians, "Gaussian"),
                     sides_text(measuring.box->core, scale))});
  return rows;
}

std::string scale_preview(const Viewer& v) {
  const auto scale = typed_scale(v.measures);
  return scale ? scale_text(*scale) : "Set two points at a known distance.";
}

std::filesystem::path kept_measures_file(const std::filesystem::path& scene) {
  return scene.string() + ".measures.json";
}

bool measures_are_to_keep(const Viewer& v) {
  return v.scene && v.measures != v.measures.kept && v.measures.keeps && v.keeps_work &&
         !v.is_remote;
}

bool measures_are_unsaved(const Viewer& v) {
  return v.scene && v.measures != v.measures.kept && !measures_are_to_keep(v);
}

namespace action {

void toggle_measuring(Viewer& v) {
  toggle_panel(v, &Panels::measures);
  pick_points(v, v.panels.measures);
}

void pick_points(Viewer& v, bool picks) {
  v.measures.picks = picks;
  v.measures.again = false;
  if (!picks) return;
  v.selecting.tool.reset();
  v.selecting.drawn.clear();
  notify(v, "a click sets a point on a surface, Enter begins a new line, Escape ends");
}

void pick_again(Viewer& v, bool again) {
  if (again) pick_points(v, true);
  v.measures.again = again;
  if (again) notify(v, "turn the view, then click where it shows the last point");
}

void end_line(Viewer& v) {
  if (!v.measures.lines.back().empty()) v.measures.lines.emplace_back();
}

void remove_last_point(Viewer& v) {
  auto& lines = v.measures.lines;
  if (lines.back().empty() && lines.size() > 1) lines.pop_back();
  if (!lines.back().empty()) lines.back().pop_back();
  v.measures.hidden_version = v.measures.asked_version = -1;
}

void clear_measures(Viewer& v) {
  v.measures.lines = {{}};
  v.measures.box.reset();
}

void copy_measures(Viewer& v, Host& host) {
  if (!v.scene) return;
  std::string text;
  for (const MeasureRow& row : rows_of_measures(v))
    text += fmt::format("{}\t{}\t{}\n", row.name, row.value, row.more);
  if (text.empty()) return notify(v, "there is nothing to copy: no point is measured");
  if (v.is_remote) return host.write_file("measures.tsv", text);
  host.set_clipboard(text);
  notify(v, "copied the measures as a table");
}

void set_scale(Viewer& v) {
  const auto scale = typed_scale(v.measures);
  if (!scale) return notify(v, scale_preview(v));
  v.measures.scale = *scale;
  notify(v, scale_preview(v) + "; the scene's values stay");
}

void set_ground(Viewer& v) {
  const auto points = last_points<3>(v.measures);
  if (!points || !v.scene) return notify(v, "set three points on the ground first");
  v.measures.ground = ground_through(*points);
  if (!v.measures.ground) return notify(v, "these three points lie on a line");
  declare_up(v, v.measures.ground->up);
  const double error = degrees_of_tilt_error(*points);
  constexpr double kLargeError = 3;
  notify(v, fmt::format(
                "the three points are level, ± {:.2g} degrees: this side of the ground is up "
                "from now on{}",
                error,
                error > kLargeError ? "; points that are farther from one line are better" : ""));
}

void move_cross(Viewer& v, glm::dvec2 by) {
  constexpr double kTurnPixels = 10;
  if (!v.has_tool()) return (v.navigation == Navigation::fly ? look : orbit)(v, -kTurnPixels * by);
  const glm::dvec2 size(v.camera.width, v.camera.height);
  v.cross = glm::clamp(v.cross.value_or(glm::floor(0.5 * size)) + by, glm::dvec2(0), size - 1.0);
  v.cross_is_used = false;
}

void restore_measures(Viewer& v, Host& host) {
  const std::filesystem::path file = kept_measures_file(v.scene->path);
  if (v.keeps_work && !v.is_remote && is_there(file)) open_measures(v, host, file);
}

void measures_opened(Viewer& v, const std::filesystem::path& file, const Measures& measures) {
  if (!v.scene) return;
  PointMeasures& measuring = v.measures;
  measuring.owns_file = file == kept_measures_file(v.scene->path);
  static_cast<Measures&>(measuring) = measures;
  if (!measuring.lines.back().empty()) measuring.lines.emplace_back();  // the next point's
  if (measuring.owns_file) measuring.kept = measuring;
  measuring.hidden_version = measuring.asked_version = -1;
  // The window remembers the up of its scenes.
  if (measuring.ground && !measuring.owns_file) declare_up(v, measuring.ground->up);
  std::string text = counted(measuring.points(), "measured point");
  if (measuring.scale != MeasureScale()) text += ", " + scale_text(measuring.scale);
  if (measuring.ground) text += ", the ground";
  notify(v, fmt::format("{}: {} (Shift+M)", file.filename().string(), text));
}

void measures_kept(Viewer& v, const std::string& problem) {
  v.measures.owns_file = v.measures.keeps = problem.empty();
  if (!problem.empty())
    notify_error(v, problem + "; Save in the panel Measure saves them elsewhere");
}

void point_measured(Viewer& v, const std::optional<SurfacePoint>& point) {
  PointMeasures& measuring = v.measures;
  if (!std::exchange(measuring.busy, false)) return;  // another scene was opened
  if (!point) return notify(v, "no surface is here: more than half of the light passes");
  measuring.lines.back().push_back(*point);
  measuring.hidden_version = measuring.asked_version = -1;
  if (point->is_soft()) notify(v, "a soft surface: this point is uncertain");
}

void rulers_hidden(Viewer& v, int view_version, const std::vector<std::vector<bool>>& hidden) {
  PointMeasures& measuring = v.measures;
  if (measuring.asked_version != view_version) return;  // the points have changed
  measuring.hidden = hidden;
  measuring.hidden_version = view_version;
  if (hidden.empty()) measuring.asked_version = -1;
}

void box_measured(Viewer& v, const MeasuredBox& box) {
  if (std::exchange(v.measures.busy, false)) v.measures.box = box;
}

}  // namespace action
}  // namespace qs
