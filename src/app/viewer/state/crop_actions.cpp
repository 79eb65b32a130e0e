// SPDX-License-Identifier: MIT
#include "app/viewer/state/crop_actions.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "app/framing/camera_control.h"
#include "app/session/removal_text.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/edit_actions.h"
#include "app/viewer/state/training_actions.h"
#include "base/text.h"

namespace qs {

CropRequest wanted_crop(const Viewer& viewer) {
  const Crop& crop = viewer.crop;
  if (!viewer.scene || viewer.remote || is_training(viewer)) return {};
  CropRequest request{
      .gone = viewer.editing.gone, .steps = viewer.editing.steps, .pages = viewer.editing.pages};
  if (viewer.scene->nodes > 0) {
    if (viewer.panels.crop) request.selected = viewer.editing.selected;
  } else if (viewer.panels.crop && (crop.wish.removes() || viewer.editing.selected)) {
    request.wish = crop.wish;
    request.selected = viewer.editing.selected;
  }
  return request;
}

namespace {

// The pixel of a point in view space, in front of the camera.
glm::dvec2 projected(const Camera& camera, glm::dvec3 point) {
  return glm::dvec2(point) / point.z * camera.focal_px + camera.center_px;
}

}  // namespace

CropBox first_box(const ViewedScene& scene, glm::dvec3 eye) {
  const SceneBox& around = scene.subject.size() != glm::vec3(0) ? scene.subject : scene.core;
  const glm::vec3 size = glm::max(around.size(), glm::vec3(2 * scene.smallest_radius));
  CropBox box;
  for (const float more : {0.25f, 0.1f, 0.02f}) {
    box = {around.low - more * size, around.high + more * size};
    if (!box.contains(glm::vec3(eye))) break;
  }
  return box;
}

std::string crop_text(const Viewer& viewer) {
  const Crop& crop = viewer.crop;
  if (!crop.wish.removes() && !viewer.editing.selected) {
    const std::string text = edits_text(viewer);
    return text.empty() ? "Choose a box or floaters, or select Gaussians." : text;
  }
  if (viewer.levels)
    return viewer.editing.selected
               ? fmt::format("{} of {} drawn nodes are selected", grouped(viewer.levels->selected),
                             grouped(viewer.levels->drawn))
               : "The box crops all pages.";
  if (!crop.counts || crop.asked != wanted_crop(viewer))
    return crop.busy ? "counting" : "not counted";
  return removal_text(*crop.counts, "would go");
}

glm::dvec3 handle_of(const CropBox& box, int face) {
  glm::dvec3 place = 0.5 * (glm::dvec3(box.low) + glm::dvec3(box.high));
  const int axis = face / 2;
  place[axis] = static_cast<double>(face % 2 == 0 ? box.low[axis] : box.high[axis]);
  return place;
}

std::optional<PictureLine> line_in_picture(const Camera& camera, glm::dvec3 from, glm::dvec3 to) {
  glm::dvec3 a = camera.view_from_world * glm::dvec4(from, 1);
  glm::dvec3 b = camera.view_from_world * glm::dvec4(to, 1);
  const double near_depth = camera.near_depth;
  if (a.z < near_depth && b.z < near_depth) return std::nullopt;
  if (a.z < near_depth) a += (near_depth - a.z) / (b.z - a.z) * (b - a);
  if (b.z < near_depth) b += (near_depth - b.z) / (a.z - b.z) * (a - b);
  return PictureLine{projected(camera, a), projected(camera, b)};
}

std::vector<PictureLine> box_lines(const Camera& camera, const CropBox& box) {
  const glm::dvec3 ends[] = {glm::dvec3(box.low), glm::dvec3(box.high)};
  const auto corner = [&](int bits) {
    return glm::dvec3(ends[bits & 1].x, ends[bits >> 1 & 1].y, ends[bits >> 2].z);
  };
  std::vector<PictureLine> lines;
  for (int from = 0; from < 8; ++from) {
    for (const int axis : {1, 2, 4}) {
      if ((from & axis) != 0) continue;
      if (const auto line = line_in_picture(camera, corner(from), corner(from | axis)))
        lines.push_back(*line);
    }
  }
  return lines;
}

std::optional<glm::dvec2> handle_in_picture(const Camera& camera, const CropBox& box, int face) {
  const glm::dvec3 at = camera.view_from_world * glm::dvec4(handle_of(box, face), 1);
  if (at.z <= camera.near_depth) return std::nullopt;
  return projected(camera, at);
}

std::optional<double> slide_along(const Camera& camera, glm::dvec3 point, glm::dvec3 direction,
                                  glm::dvec2 pixel) {
  constexpr double kLeastSine2 = 1e-6;
  const glm::dvec3 eye = camera.position();
  const glm::dvec3 ray = glm::normalize(point_at(camera, pixel, 1) - eye);
  const glm::dvec3 from_eye = point - eye;
  const double cosine = glm::dot(direction, ray), sine2 = 1 - cosine * cosine;
  if (!(sine2 > kLeastSine2)) return std::nullopt;
  const double along = glm::dot(direction, from_eye), ahead = glm::dot(ray, from_eye);
  if ((ahead - cosine * along) / sine2 <= 0) return std::nullopt;
  return (cosine * ahead - along) / sine2;
}

std::optional<CropBox> dragged(const CropBox& box, int face, const Camera& camera,
                               glm::dvec2 pixel) {
  const int axis = face / 2;
  const bool low = face % 2 == 0;
  glm::dvec3 direction(0.0);
  direction[axis] = 1;
  const glm::dvec3 handle = handle_of(box, face);
  const auto by = slide_along(camera, handle, direction, pixel);
  if (!by) return std::nullopt;
  const auto at = static_cast<float>(handle[axis] + *by);
  CropBox moved = box;
  (low ? moved.low : moved.high)[axis] =
      low ? std::min(at, box.high[axis]) : std::max(at, box.low[axis]);
  return moved;
}

void action::change_crop(Viewer& v, const CropWish& wish) {
  if (!v.scene || wish == v.crop.wish) return;
  const CropWish before = std::exchange(v.crop.wish, wish);
  CropBox& box = v.crop.wish.box;
  if (wish.boxed && box == CropBox{}) box = first_box(*v.scene, v.camera.position());
  for (int axis = 0; axis < 3; ++axis) {
    if (box.low[axis] <= box.high[axis]) continue;
    if (box.low[axis] != before.box.low[axis]) {
      box.low[axis] = box.high[axis];
    } else {
      box.high[axis] = box.low[axis];
    }
  }
}

void action::choose_crop(Viewer& v, const std::string& words) {
  CropWish wish = v.crop.wish;
  if (words == "floaters") {
    wish.cleans = true;
  } else if (words == "nothing") {
    wish.boxed = wish.cleans = false;
    v.editing = Editing();
  } else {
    wish.boxed = true;
    wish.box = parse_crop_box("crop", words, v.scene ? v.scene->origin : glm::dvec3(0));
  }
  change_crop(v, wish);
}

void action::mark_removed(Viewer& v, bool marks) {
  v.crop.marks = marks;
  picture_changed(v);
}

void action::fit_crop_box(Viewer& v) {
  if (!v.scene) return;
  CropWish wish = v.crop.wish;
  wish.boxed = true;
  wish.box = first_box(*v.scene, v.camera.position());
  change_crop(v, wish);
}

void action::show_crop_box(Viewer& v) {
  if (!v.scene || !v.crop.wish.boxed) return;
  constexpr double kMargin = 1.1;
  const CropBox& box = v.crop.wish.box;
  const glm::dvec3 center = 0.5 * (glm::dvec3(box.low) + glm::dvec3(box.high));
  const double radius = kMargin * 0.5 * glm::distance(glm::dvec3(box.low), glm::dvec3(box.high));
  const glm::dvec2 half =
      0.5 * glm::dvec2(v.camera.width, v.camera.height) / glm::dvec2(v.camera.focal_px);
  const double distance = radius / std::sin(std::atan(std::min(half.x, half.y)));
  const glm::dvec3 seen = v.camera.view_from_world * glm::dvec4(center, 1);
  v.pivot = center;
  move(v, stepped(v.camera, seen - glm::dvec3(0, 0, distance)));
}

void action::apply_crop(Viewer& v) {
  const Crop& crop = v.crop;
  if (!v.scene || v.editing.busy || !v.editing.waiting.empty()) return;
  if (!crop.wish.removes()) {
    v.panels.crop = true;
    return notify(v, "choose a box or floaters first");
  }
  if (crop.wish.boxed) edit(v, {.kind = EditKind::crop, .box = crop.wish.box});
  if (crop.wish.cleans) edit(v, {.kind = EditKind::floaters, .floaters = crop.wish.floaters});
}

void action::toggle_crop(Viewer& v) {
  v.crop.wish.removes() || !v.editing.history.can_undo() ? apply_crop(v) : step_back(v, true);
}

void action::crop_shown(Viewer& v, const CropRequest& request, const ShownCrop& shown) {
  Crop& crop = v.crop;
  crop.busy = false;
  crop.counts = shown.counts;
  crop.asked = request;
  if (std::exchange(crop.tint, shown.tint) != shown.tint) picture_changed(v);
  if (v.scene && v.scene->edits != shown.edits) show_edits(v, shown.edits, shown.gaussians);
}

void show_edits(Viewer& v, const EditFacts& edits, std::uint64_t gaussians) {
  v.scene->edits = edits;
  v.scene->gaussians = gaussians;
  v.inspected.reset();
  action::view_changed(v);
}

void action::crop_failed(Viewer& v, const std::string& sentence) {
  v.crop.busy = false;
  v.crop.counts.reset();
  if (v.editing.pages) step_back(v, true);  // the pages do not have the step
  notify_error(v, sentence);
}

}  // namespace qs
