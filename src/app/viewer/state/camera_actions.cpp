// SPDX-License-Identifier: MIT
#include "app/viewer/state/camera_actions.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "app/framing/camera_control.h"
#include "app/framing/first_view.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/kept_work.h"
#include "base/error.h"
#include "base/text.h"
#include "io/camera/cameras.h"
#include "io/cloud/axes.h"

namespace qs {
namespace {

// The value that the settings have for a scene file; unset if they were edited by hand.
template <class Parse>
auto kept_for(const std::map<std::string, std::string>& texts, const std::filesystem::path& scene,
              const Parse& parse) -> std::optional<decltype(parse(std::string()))> {
  const auto kept = texts.find(scene.string());
  if (kept == texts.end()) return {};
  try {
    return parse(kept->second);
  } catch (const Error&) {
    return {};
  }
}

std::optional<Camera> camera_for(const std::map<std::string, std::string>& views,
                                 const std::filesystem::path& scene) {
  return kept_for(views, scene,
                  [](const std::string& text) { return parse_camera(text, "settings"); });
}

Camera framed(const Viewer& v, const Framing& framing) {
  return framed_camera(framing, std::max(v.camera.width, 1), std::max(v.camera.height, 1));
}

Camera fitted(const Viewer& v, const Camera& camera) {
  return v.camera.width > 0 ? camera.resized(v.camera.width, v.camera.height) : camera;
}

// The first camera of the data set, else the chosen first view, else the framed scene.
Camera first_view(const Viewer& v, const ViewedScene& scene) {
  if (!scene.cameras.empty()) return fitted(v, scene.cameras.front());
  if (const auto chosen = camera_for(v.first_views, scene.path)) return fitted(v, *chosen);
  return framed(v, scene.framing);
}

}  // namespace

void use_cameras(ViewedScene& scene) {
  if (scene.cameras.empty()) return;
  if (!scene.up_is_declared) scene.up = cameras_up(scene.cameras, scene.up);
  scene.framing = framing_of(scene.cameras, scene.up).value_or(scene.framing);
}

std::optional<glm::dvec3> remembered_up(const Viewer& v, const std::filesystem::path& scene) {
  return kept_for(v.ups, scene,
                  [](const std::string& text) { return parse_direction("settings", text); });
}

std::string remembered_axes(const Viewer& v, const std::filesystem::path& scene) {
  const auto kept = v.axes.find(scene.string());
  return kept != v.axes.end() && is_axes(kept->second) ? kept->second : "";
}

std::optional<Camera> last_view(const Viewer& v, const std::filesystem::path& scene) {
  return v.restores_views ? camera_for(v.last_views, scene) : std::nullopt;
}

const Bookmarks& bookmarks_of(const Viewer& v) {
  static const Bookmarks kNone;
  const auto kept = v.scene ? v.bookmarks.find(work_name(*v.scene)) : v.bookmarks.end();
  return kept == v.bookmarks.end() ? kNone : kept->second;
}

Camera opening_view(const Viewer& v, const ViewedScene& scene) {
  if (const std::optional<Camera> last = last_view(v, scene.path)) return fitted(v, *last);
  return first_view(v, scene);
}

bool is_unknown(const Viewer& v, const ViewedScene& scene) {
  const std::string path = scene.path.string();
  return !v.last_views.contains(path) && !v.first_views.contains(path);
}

namespace action {
namespace {

constexpr double kRadiansPerPixel = 0.005, kDollyPerNotch = 0.9, kFovPerNotch = 0.94;
constexpr double kRadiansPerRollNotch = glm::radians(2.0);

glm::dvec3 up_of(const Viewer& v) { return v.scene ? v.scene->up : glm::dvec3(0, -1, 0); }

/// Distance of the pivot in front of the camera, > 0, world units.
double pivot_depth(const Viewer& v) {
  const double least = v.scene ? 1e-3 * v.scene->extent() : 1e-3;
  return std::max(depth_of(v.camera, v.pivot), least);
}

/// The pivot until the user picks one: the point of the line of sight nearest to the target of F's
/// view.
glm::dvec3 natural_pivot(const Camera& camera, const ViewedScene& scene) {
  const double depth = std::max(depth_of(camera, scene.framing.target), 0.05 * scene.extent());
  return camera.position() + depth * view_axes(camera).forward;
}

/// Travels to a view, after the end of the move before it.
void go(Viewer& v, const Camera& camera, glm::dvec3 pivot, int dataset_camera = -1) {
  complete_move(v);
  v.pivot = pivot;
  travel_to(v, camera, dataset_camera);
}

/// Resizes the camera to the window.
void set_view(Viewer& v, const Camera& camera) {
  v.travel.reset();
  v.view_choice = {};
  v.camera = fitted(v, camera);
  view_changed(v);
}

/// The camera of the data set at the current view, or at the end of the current travel; -1: none.
int destination(const Viewer& v) { return v.travel ? v.travel->dataset_camera : v.dataset_camera; }

int nearest_camera(const Viewer& v) {
  const std::vector<Camera>& cameras = v.scene->cameras;
  const ViewAxes here = view_axes(v.camera);
  const auto distance = [&](const Camera& other) {
    // Turning by 180 degrees counts as a distance of one extent.
    const double apart = glm::distance(other.position(), v.camera.position());
    const double turned = 0.5 * (1 - glm::dot(here.forward, view_axes(other).forward));
    return apart + turned * v.scene->extent();
  };
  return static_cast<int>(std::ranges::min_element(cameras, {}, distance) - cameras.begin());
}

// Goes to a view of the history, or says that there is none.
void go_to_past(Viewer& v, Host& host, const PastView* (ViewHistory::*step)(),
                const char* nothing) {
  if (!v.scene) return;
  v.playback.running = false;
  complete_move(v);  // a move that has not ended yet
  const PastView* found = (v.history.*step)();
  if (found == nullptr) {
    if (v.toasts.empty() || v.toasts.back().text != nothing) notify(v, nothing);
    return;
  }
  const PastView past = *found;
  v.pivot = past.pivot;
  travel_to(v, past.camera, past.dataset_camera);
  read_photograph(v, host);
}

}  // namespace

void move(Viewer& v, const Camera& camera) {
  v.travel.reset();
  v.view_choice = {};
  v.camera = camera;
  v.dataset_camera = -1;
  v.last_motion = v.now;
  view_changed(v);
}

void orbit(Viewer& v, glm::dvec2 pixels) {
  const glm::dvec2 angles = kRadiansPerPixel * pixels;
  move(v, orbited(v.camera, v.pivot, up_of(v), angles.x, angles.y));
}

void look(Viewer& v, glm::dvec2 pixels) {
  // The point under the cursor stays under the cursor.
  const glm::dvec2 angles = pixels / v.camera.focal_px;
  move(v, turned(v.camera, up_of(v), -angles.x, angles.y));
}

void shift(Viewer& v, glm::dvec3 step) {
  const ViewAxes axes = view_axes(v.camera);
  v.pivot += step.x * axes.right + step.y * axes.down + step.z * axes.forward;
  move(v, stepped(v.camera, step));
}

void pan(Viewer& v, glm::dvec2 pixels) { shift(v, pan_step(v.camera, pivot_depth(v), pixels)); }

void dolly(Viewer& v, double notches) {
  const double depth = pivot_depth(v);
  move(v, stepped(v.camera, {0, 0, depth - depth * std::pow(kDollyPerNotch, notches)}));
}

void change_fov(Viewer& v, double notches) {
  move(v, with_vertical_fov(v.camera, vertical_fov(v.camera) * std::pow(kFovPerNotch, notches)));
}

void roll(Viewer& v, double notches) { move(v, rolled(v.camera, kRadiansPerRollNotch * notches)); }

void set_camera(Viewer& v, const Camera& camera) {
  complete_move(v);
  set_view(v, camera);
  v.dataset_camera = -1;
  if (v.scene) v.pivot = natural_pivot(v.camera, *v.scene);
  complete_move(v);
}

void frame_point(Viewer& v, glm::dvec3 point) {
  const glm::dvec3 to_eye = v.camera.position() - point;
  const double distance = glm::length(to_eye);
  const double kept = std::min(distance, std::max(0.5 * distance, 3 * v.camera.near_depth));
  notify(v, fmt::format("pivot at {:.4g}, {:.4g}, {:.4g}", point.x, point.y, point.z));
  if (!(distance > 0)) {
    v.pivot = point;
    return;
  }
  const glm::dvec3 direction = to_eye / distance;
  Camera camera = moved_to(v.camera, point + kept * direction);
  constexpr double kNearPole = 0.999;
  if (std::abs(glm::dot(direction, up_of(v))) < kNearPole)
    camera.view_from_world = look_at(camera.position(), point, up_of(v), vertical_fov(camera),
                                     camera.width, camera.height)
                                 .view_from_world;
  go(v, camera, point);
}

void resize(Viewer& v, int width, int height) {
  if (width < 1 || height < 1) return;
  if (width == v.camera.width && height == v.camera.height) return;
  if (v.travel) {
    v.travel->from = v.travel->from.resized(width, height);
    v.travel->to = v.travel->to.resized(width, height);
  }
  if (v.camera.width > 0) {
    v.camera = v.camera.resized(width, height);
  } else {
    v.camera.width = width;
    v.camera.height = height;
  }
  view_changed(v);
}

void frame_scene(Viewer& v) {
  if (!v.scene) return;
  go(v, framed(v, v.scene->framing), v.scene->framing.target);
}

void read_photograph(Viewer& v, Host& host) {
  if (!v.panels.photograph || destination(v) < 0) return;
  const auto found = v.scene->photographs.find(destination(v));
  if (found == v.scene->photographs.end() || found->second == v.photograph.path) return;
  v.photograph = {found->second, nullptr};
  host.read_photograph(found->second);
}

void go_to_camera(Viewer& v, Host& host, int index) {
  if (!v.scene || index < 0 || index >= static_cast<int>(v.scene->cameras.size())) return;
  const Camera& camera = v.scene->cameras[static_cast<std::size_t>(index)];
  go(v, camera, natural_pivot(camera, *v.scene), index);
  read_photograph(v, host);
}

void step_camera(Viewer& v, Host& host, CameraStep step) {
  if (!v.scene || v.scene->cameras.empty())
    return notify(v, "this scene has no cameras: drop its cameras.json on the window");
  const int count = static_cast<int>(v.scene->cameras.size());
  const int at = destination(v) < 0 ? nearest_camera(v) : destination(v);
  if (step == CameraStep::nearest) return go_to_camera(v, host, nearest_camera(v));
  const int steps[] = {at + count - 1, at + 1, 0, count - 1};  // index = CameraStep
  go_to_camera(v, host, steps[static_cast<int>(step)] % count);
}

void go_home(Viewer& v, Host& host) {
  if (!v.scene) return;
  if (!v.scene->cameras.empty()) return go_to_camera(v, host, 0);
  const bool chosen = camera_for(v.first_views, v.scene->path).has_value();
  go(v, v.home, chosen ? natural_pivot(v.home, *v.scene) : v.scene->framing.target);
}

void complete_move(Viewer& v) {
  if (!v.scene || v.travel || v.camera.width < 1) return;
  v.history.keep({v.camera, v.pivot, v.dataset_camera});
}

void undo_move(Viewer& v, Host& host) {
  go_to_past(v, host, &ViewHistory::back, "there is no earlier view of this scene");
}

void redo_move(Viewer& v, Host& host) {
  go_to_past(v, host, &ViewHistory::forward, "there is no later view of this scene");
}

void declare_up(Viewer& v, glm::dvec3 up) {
  ViewedScene& scene = *v.scene;
  scene.up = up;
  scene.up_is_declared = true;
  scene.framing.up = scene.up;
  const glm::dvec3 seen = scene.framing.target - scene.framing.eye;
  if (std::abs(glm::dot(seen, scene.up)) > 0.98 * glm::length(seen))  // it would look up or down
    scene.framing = {v.camera.position(), v.pivot, scene.up, vertical_fov(v.camera)};
  for (Framing& candidate : scene.candidates) candidate.up = scene.up;
  use_cameras(scene);
  v.ups[scene.path.string()] = fmt::format("{},{},{}", up.x, up.y, up.z);
}

void make_upright(Viewer& v) {
  if (!v.scene) return;
  declare_up(v, -view_axes(v.camera).down);
  notify(v, "this view is upright from now on: --up " + v.ups[v.scene->path.string()]);
}

void set_first_view(Viewer& v, Host& host) {
  v.home = first_view(v, *v.scene);
  v.dataset_camera = -1;
  go_home(v, host);
  arrive(v);
  v.home = v.camera;
}

void offer_views(Viewer& v) {
  v.view_choice = {v.scene && v.scene->cameras.empty() && v.scene->candidates.size() > 1};
}

void ask_for_views(Viewer& v) {
  if (!v.scene) return;
  offer_views(v);
  if (v.view_choice.wanted) return;
  notify(v, v.scene->cameras.empty()
                ? "this scene has no other views to choose from: Home goes to its first view"
                : "this scene starts at its first camera: [ and ] go to the others");
}

void candidates_drawn(Viewer& v, const std::filesystem::path& scene,
                      const std::shared_ptr<const Image>& pictures) {
  if (!v.view_choice.asked || !v.scene || v.scene->path != scene) return;
  v.view_choice = {};
  v.view_choice.pictures = pictures;
}

void choose_first_view(Viewer& v, Host& host, std::size_t index) {
  if (!v.scene || index >= v.scene->candidates.size() || !v.scene->cameras.empty()) return;
  v.view_choice = {};
  v.home = framed_camera(v.scene->candidates[index], v.camera.width, v.camera.height);
  v.first_views[v.scene->path.string()] = format_camera(v.home);
  go_home(v, host);
}

void close_view_choice(Viewer& v) { v.view_choice = {}; }

void keep_bookmark(Viewer& v) {
  if (!v.scene) return;
  Bookmarks& kept = v.bookmarks[work_name(*v.scene)];
  kept.emplace_back(fmt::format("view {}", kept.size() + 1), format_camera(v.camera));
  v.panels.cameras = true;
}

void name_bookmark(Viewer& v, std::size_t index, const std::string& name) {
  if (index < bookmarks_of(v).size()) v.bookmarks[work_name(*v.scene)][index].first = name;
}

void remove_bookmark(Viewer& v, std::size_t index) {
  if (index >= bookmarks_of(v).size()) return;
  Bookmarks& kept = v.bookmarks[work_name(*v.scene)];
  kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(index));
}

void go_to_bookmark(Viewer& v, std::size_t index) {
  if (index >= bookmarks_of(v).size()) return;
  const Camera camera = parse_camera(bookmarks_of(v)[index].second, "settings");
  go(v, camera, natural_pivot(camera, *v.scene));
}

}  // namespace action
}  // namespace qs
