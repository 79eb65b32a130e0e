// SPDX-License-Identifier: MIT
#include "app/viewer/state/actions.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vector_relational.hpp>

#include "app/measure/zoom_path.h"
#include "app/session/camera_control.h"
#include "app/viewer/state/changes.h"
#include "io/camera/cameras.h"
#include "io/scene/axes.h"

namespace qs {
namespace {

using namespace action;

constexpr double kRadiansPerPixel = 0.005, kDollyPerNotch = 0.9, kFovPerNotch = 0.94;
constexpr double kRadiansPerRollNotch = glm::radians(2.0);
constexpr double kFlyExtentsPerSecond = 0.25;  ///< of the scene's extent
constexpr std::size_t kMostRecent = 10, kMostFrames = 120;

void remember(Viewer& viewer, const std::filesystem::path& path) {
  std::erase(viewer.recent, path);
  viewer.recent.insert(viewer.recent.begin(), path);
  if (viewer.recent.size() > kMostRecent) viewer.recent.resize(kMostRecent);
}

// Overloads: what each action does.
void on(Viewer& v, const SetMode& a) {
  if (a.mode == v.settings.mode || a.mode < 1 || a.mode > kCullerCount) return;
  v.previous_mode = std::exchange(v.settings.mode, a.mode);
  picture_changed(v);
}
void on(Viewer& v, const PeekPreviousMode& a) {
  if (v.peeking == a.held) return;
  v.peeking = a.held;
  picture_changed(v);
}
void on(Viewer& v, const ToggleHeatmap&) {
  v.heatmap = v.heatmap ? std::nullopt : std::optional(v.last_heatmap);
  picture_changed(v);
}
void on(Viewer& v, const NextHeatmap&) {
  const std::size_t next = (static_cast<std::size_t>(v.last_heatmap) + 1) % kHeatQuantities;
  v.last_heatmap = v.heatmap ? static_cast<HeatQuantity>(next) : v.last_heatmap;
  v.heatmap = v.last_heatmap;
  picture_changed(v);
}
void on(Viewer& v, const ChangeSplit& a) {
  const bool another = a.split.other != v.split.other;
  v.split = a.split;
  if (another && v.panels.split) picture_changed(v);
}
void on(Viewer& v, const FlipSplit&) { v.split.flipped = !v.split.flipped; }
void on(Viewer& v, const NextSplitView&) {
  const auto next = (static_cast<std::size_t>(v.split.view) + 1) % std::size(kSplitViews);
  v.split.view = static_cast<SplitView>(next);
}
void on(Viewer& v, const ScaleSplats& a) {
  v.settings.splat_scale = std::clamp(v.settings.splat_scale * a.factor, 0.01f, 10.0f);
  if (std::abs(v.settings.splat_scale - 1) < 1e-3f) v.settings.splat_scale = 1;
  view_changed(v);
}
void on(Viewer& v, const ChangeSettings& a) {
  v.settings = a.settings;
  view_changed(v);
}
void on(Viewer& v, const ChangeBackend& a) {
  if (a.backend != v.backend) request_now(v, request::SwitchBackend{a.backend});
}

void on(Viewer& v, const Orbit& a) {
  const glm::dvec3 up = v.scene ? v.scene->up : glm::dvec3(0, -1, 0);
  const glm::dvec2 angles = kRadiansPerPixel * a.pixels;
  move(v, orbited(v.camera, v.pivot, up, angles.x, angles.y));
}
void on(Viewer& v, const Look& a) {
  const glm::dvec3 up = v.scene ? v.scene->up : glm::dvec3(0, -1, 0);
  // What is under the cursor stays there.
  const glm::dvec2 angles = a.pixels / v.camera.focal_px;
  move(v, turned(v.camera, up, -angles.x, angles.y));
}
void on(Viewer& v, const Pan& a) {
  const glm::dvec3 step = pan_step(v.camera, pivot_depth(v), a.pixels);
  const ViewAxes axes = view_axes(v.camera);
  move(v, stepped(v.camera, step));
  v.pivot += step.x * axes.right + step.y * axes.down;
}
void on(Viewer& v, const Dolly& a) {
  const double depth = pivot_depth(v);
  const double goal = depth * std::pow(kDollyPerNotch, a.notches);
  move(v, stepped(v.camera, {0, 0, depth - goal}));
}
void on(Viewer& v, const ChangeFov& a) {
  move(v, with_vertical_fov(v.camera, vertical_fov(v.camera) * std::pow(kFovPerNotch, a.notches)));
}
void on(Viewer& v, const Roll& a) { move(v, rolled(v.camera, kRadiansPerRollNotch * a.notches)); }
void on(Viewer& v, const Fly& a) {
  if (!v.scene || a.direction == glm::dvec3(0)) return;
  const double distance = kFlyExtentsPerSecond * v.scene->extent() * a.factor * a.seconds;
  const glm::dvec3 step = distance * a.direction;
  const ViewAxes axes = view_axes(v.camera);
  move(v, stepped(v.camera, step));
  v.pivot += step.x * axes.right + step.y * axes.down + step.z * axes.forward;
}
void on(Viewer& v, const ToggleNavigation&) {
  v.navigation = v.navigation == Navigation::orbit ? Navigation::fly : Navigation::orbit;
  say(v, v.navigation == Navigation::orbit ? "orbit: drag turns around the pivot"
                                           : "fly: drag looks around, W A S D moves");
}
void on(Viewer& v, const FrameScene&) {
  if (!v.scene) return;
  move(v, framed(v));
  v.pivot = glm::dvec3(v.scene->core.center());
}
void on(Viewer& v, const GoHome&) {
  if (!v.scene) return;
  if (!v.scene->cameras.empty()) return go_to_camera(v, 0);
  set_view(v, v.home);
  v.pivot = glm::dvec3(v.scene->core.center());
}
void on(Viewer& v, const StepCamera& a) { step_camera(v, a.step); }
void on(Viewer& v, const GoToCamera& a) {
  if (v.scene) go_to_camera(v, a.index);
}
void on(Viewer& v, const PickPivot& a) {
  if (v.scene) request_now(v, request::Pick{a.pixel, false});
}
void on(Viewer& v, const SetPivot& a) {
  v.pivot = a.point;
  say(v, fmt::format("pivot at {:.4g}, {:.4g}, {:.4g}", a.point.x, a.point.y, a.point.z));
}
void on(Viewer& v, const SetCamera& a) {
  set_view(v, a.camera);
  v.dataset_camera = -1;
  if (v.scene) v.pivot = natural_pivot(v.camera, *v.scene);
}
void on(Viewer& v, const Resize& a) {
  if (a.width < 1 || a.height < 1) return;
  if (a.width == v.camera.width && a.height == v.camera.height) return;
  if (v.camera.width > 0) {
    v.camera = v.camera.resized(a.width, a.height);
  } else {
    v.camera.width = a.width;
    v.camera.height = a.height;
  }
  view_changed(v);
}

void on(Viewer& v, const TogglePanel& a) {
  v.panels.*a.panel = !(v.panels.*a.panel);
  if (a.panel != &Panels::split) return;
  if (v.split.other == v.variant()) v.split.other.mode = v.previous_mode;
  picture_changed(v);
}
void on(Viewer& v, const TogglePhotograph&) {
  if (!v.scene || v.scene->photographs.empty()) {
    return say(v,
               "no photographs were found: they are looked for in a folder 'images' beside the "
               "cameras");
  }
  v.panels.photograph = !v.panels.photograph;
  if (v.panels.photograph && v.dataset_camera < 0) step_camera(v, CameraStep::nearest);
  read_photograph(v);
}
void on(Viewer& v, const ToggleFullscreen&) { request_now(v, request::Fullscreen{}); }
void on(Viewer& v, const TakeScreenshot& a) {
  if (v.scene) request_now(v, request::Screenshot{a.with_ui});
}
void on(Viewer& v, const CopyCamera&) {
  request_now(v, request::CopyText{format_camera(v.camera)});
  say(v, "camera copied as JSON, ready for --camera-json");
}
void on(Viewer& v, const PasteCamera&) { request_now(v, request::PasteText{}); }
void on(Viewer& v, const Open& a) { request_now(v, request::Open{a.path, {}}); }
void on(Viewer& v, const Reload&) {
  if (v.scene) request_now(v, request::Open{v.scene->path, v.scene->axes});
}
// The file's own, then all others, and so on.
void on(Viewer& v, const NextAxes&) {
  if (!v.scene) return;
  const auto* here = std::find(kAxes.begin(), kAxes.end(), v.scene->axes);
  const auto* next = v.scene->axes.empty() ? kAxes.begin() : here == kAxes.end() ? here : here + 1;
  const std::string axes(next == kAxes.end() ? "" : *next);
  say(v, axes.empty() ? "axes as the file has them" : "read as if its axes were " + axes);
  request_now(v, request::Open{v.scene->path, axes});
}
void on(Viewer& v, const CancelLoading&) { request_now(v, request::CancelLoading{}); }
void on(Viewer& v, const Quit&) { request_now(v, request::Quit{}); }
void on(Viewer& v, const ToggleOption& a) { v.*a.option = !(v.*a.option); }
void on(Viewer& v, const SetPhotographOpacity& a) { v.photograph_opacity = a.opacity; }

void on(Viewer& v, const ToggleZoomRecorder&) {
  if (v.zoom.running) return request_now(v, request::StopRecording{});
  if (!v.scene) return;
  v.panels.recorder = true;
  request_now(v, request::Pick{glm::dvec2(center_pixel(v.camera)), true});
}
void on(Viewer& v, const BenchView&) {
  if (v.scene) request_now(v, request::Bench{});
}
void on(Viewer& v, const InspectPixel& a) {
  const glm::dvec2 end(v.camera.width, v.camera.height);
  const bool inside = glm::all(glm::greaterThanEqual(a.pixel, glm::dvec2(0))) &&
                      glm::all(glm::lessThan(a.pixel, end));
  if (v.scene && v.panels.inspector && inside)
    request_now(v, request::Inspect{a.pixel, std::nullopt});
}
void on(Viewer& v, const InspectGaussian& a) {
  if (v.scene && v.inspected && v.inspected->version == v.version)
    request_now(v, request::Inspect{glm::dvec2(v.inspected->inspection.pixel.pixel), a.gaussian});
}
void on(Viewer& v, const AskOracle& a) {
  if (v.scene) request_now(v, request::AskOracle{a.around_cursor});
}
void on(Viewer& v, const AddKeyframe&) {
  const double time = v.keyframes.empty() ? 0 : v.keyframes.back().time + 1;
  v.keyframes.push_back({time, v.camera});
  say(v, fmt::format("keyframe {} set", v.keyframes.size()));
}
void on(Viewer& v, const RemoveKeyframe& a) {
  if (a.index >= v.keyframes.size()) return;
  v.keyframes.erase(v.keyframes.begin() + static_cast<std::ptrdiff_t>(a.index));
  v.playback = {};
}
void on(Viewer& v, const TogglePlayback&) {
  if (v.keyframes.size() < 2) return say(v, "a path needs two keyframes: set them with K");
  v.playback.running = !v.playback.running;
  if (v.playback.time >= v.keyframes.back().time) v.playback.time = v.keyframes.front().time;
}
void on(Viewer& v, const Seek& a) {
  if (v.keyframes.size() < 2) return;
  v.playback.time = std::clamp(a.time, v.keyframes.front().time, v.keyframes.back().time);
  move(v, camera_at(v.keyframes, v.playback.time).resized(v.camera.width, v.camera.height));
}
void on(Viewer& v, const SaveKeyframes&) {
  if (v.scene && v.keyframes.size() >= 2)
    request_now(v, request::SavePath{v.scene->name + "_path.json"});
}
void on(Viewer& v, const SetKeyframes& a) {
  v.keyframes = a.keyframes;
  v.playback = {};
  say(v, fmt::format("a path of {} keyframes, play it with Space", v.keyframes.size()));
}

void on(Viewer& v, const Tick& a) {
  v.now = a.now;
  std::erase_if(v.toasts, [&](const Toast& toast) { return toast.until < v.now; });
  if (!v.playback.running || v.keyframes.size() < 2) return;
  on(v, Seek{v.playback.time + a.seconds});
  if (v.playback.time >= v.keyframes.back().time) v.playback.running = false;
}
void on(Viewer& v, const SetLoading& a) { v.loading = a.loading; }
void on(Viewer& v, const SceneOpened& a) {
  const bool another = !v.scene || v.scene->path != a.scene.path || v.scene->axes != a.scene.axes;
  const CullMode mode = v.settings.mode;
  v.scene = a.scene;
  v.settings = a.settings;
  v.settings.mode = mode;
  v.backend = a.backend;
  v.loading.reset();
  remember(v, a.scene.path);
  if (another) {
    v.keyframes.clear();
    v.playback = {};
    v.zoom = {};
    v.inspected.reset();
    v.oracle.reset();
    set_first_view(v);
  }
  view_changed(v);
}
void on(Viewer& v, const BackendChanged& a) {
  v.backend = a.backend;
  v.numbers = {};
  view_changed(v);
}
void on(Viewer& v, const CamerasOpened& a) {
  if (!v.scene) return;
  v.scene->cameras = a.cameras;
  v.scene->cameras_file = a.file;
  v.scene->photographs = a.photographs;
  set_first_view(v);
  say(v, fmt::format("{} cameras from {}", a.cameras.size(), a.file.filename().string()));
}
void on(Viewer& v, const FrameShown& a) {
  v.shown = a.frame;
  if (a.frame.divisor > 1) return;
  v.frame_ms.push_back(a.frame.stats.frame_ms);
  if (v.frame_ms.size() > kMostFrames) v.frame_ms.pop_front();
}
void on(Viewer& v, const WindowMeasured& a) {
  v.display_fps = a.display_fps;
  v.present_ms = a.present_ms;
}
void on(Viewer& v, const MemoryMeasured& a) {
  v.process_bytes = a.process_bytes;
  v.gpu_bytes = a.gpu_bytes;
}
// Rows of the same view that were measured before, of the other pipeline, stay.
void on(Viewer& v, const NumbersMeasured& a) {
  const ModeNumbers before = std::exchange(v.numbers, a.numbers);
  if (before.version != a.numbers.version) return;
  for (const BenchRow& old : before.rows) {
    const bool again = std::any_of(
        a.numbers.rows.begin(), a.numbers.rows.end(),
        [&](const BenchRow& row) { return row.mode == old.mode && row.pipeline == old.pipeline; });
    if (!again) v.numbers.rows.push_back(old);
  }
}
void on(Viewer& v, const MeasuringChanged& a) { v.measuring = a.running; }
void on(Viewer& v, const PixelInspected& a) { v.inspected = a.view; }
void on(Viewer& v, const OracleAnswered& a) {
  v.oracle = a.answer;
  say(v, a.answer.sentence);
}
void on(Viewer& v, const ZoomStepped& a) {
  if (!v.zoom.running) v.zoom = {true, a.steps, {}, {}};
  v.zoom.rows.insert(v.zoom.rows.end(), a.rows.begin(), a.rows.end());
}
void on(Viewer& v, const ZoomEnded& a) {
  v.zoom.running = false;
  v.zoom.folder = a.folder;
  picture_changed(v);  // the recorder left its own picture in the window
}
void on(Viewer& v, const Say& a) { say(v, a.text, a.error); }

}  // namespace

double ViewedScene::extent() const {
  const glm::vec3 size = core.size();
  const double side = static_cast<double>(std::max({size.x, size.y, size.z}));
  return std::max(side, 2.0 * static_cast<double>(smallest_radius));
}

std::vector<std::string> not_a_measurement(const Viewer& viewer) {
  std::vector<std::string> reasons;
  if (viewer.shown.divisor > 1)
    reasons.push_back(fmt::format("drawn at 1/{} size", viewer.shown.divisor));
  if (viewer.shown.heatmap) reasons.emplace_back("with a heat map");
  if (viewer.shown.other) reasons.emplace_back("beside another one");
  if (viewer.on_demand) {
    reasons.emplace_back("drawn on demand");
  } else if (viewer.vsync) {
    reasons.emplace_back("waits for the display");
  }
  return reasons;
}

void apply(Viewer& viewer, const Action& action) {
  std::visit([&](const auto& what) { on(viewer, what); }, action);
}

}  // namespace qs
