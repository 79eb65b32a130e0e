// SPDX-License-Identifier: MIT
#include "app/viewer/view_loop.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <glm/common.hpp>

#include "app/report/stats_file.h"
#include "app/session/text.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/render/frame_orders.h"
#include "app/viewer/render/jobs.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/preferences.h"
#include "app/viewer/window/photograph_texture.h"
#include "app/viewer/window/presenter.h"
#include "app/viewer/window/script_player.h"
#include "app/viewer/window/window.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

constexpr double kIdleSeconds = 0.01;   ///< sleep while something else works
constexpr double kRestSeconds = 0.5;    ///< longest sleep
constexpr double kMovedSeconds = 0.25;  ///< after a motion the window stays awake
constexpr double kUiSeconds = 0.35;     ///< panels are drawn this long after the last event
constexpr double kFramePatience =
    0.03;  ///< the window waits this long for a frame, then shows the last one
constexpr double kMemorySeconds = 2;

std::uint64_t process_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * 4096;
}

std::uint64_t gpu_bytes(int device) {
  const GpuReport report = gpu_report();
  const auto index = static_cast<std::size_t>(device);
  if (index >= report.gpus.size()) return 0;
  return report.gpus[index].total_bytes - report.gpus[index].free_bytes;
}

class ViewLoop {
 public:
  explicit ViewLoop(const ViewOptions& options)
      : options_(options),
        preferences_(read_preferences(options.settings, problem_)),
        window_(options.frame.size.value_or(glm::ivec2(preferences_.width, preferences_.height))),
        loader_(Window::wake) {
    if (options.script) script_ = ScriptPlayer(*options.script);
    set_up_viewer();
    if (options.interop && viewer_.backend == Backend::cuda) gl_frames_.emplace(window_.handle());
    render_.emplace(options.frame, Window::wake, gl_frames_ ? &*gl_frames_ : nullptr);
    if (!options.frame.scene.empty()) open({options.frame.scene, options.frame.axes});
  }

  void run() {
    while (!quit_) {
      Actions actions;
      window_.poll(resting()             ? kRestSeconds
                   : frame_comes_first() ? kFramePatience
                   : draws()             ? 0
                                         : kIdleSeconds,
                   viewer_.navigation, actions);
      if (window_.close_requested()) actions.push_back(action::Quit{});
      const double now = glfwGetTime(), seconds = std::min(now - viewer_.now, 0.1);
      actions.insert(actions.begin(), action::Tick{now, seconds});
      play_script(actions);
      window_.input().tick(seconds, actions);
      take_reports(actions);
      for (const Action& action : actions) {
        apply(viewer_, action);
        note_change(action);
        if (std::holds_alternative<action::SceneOpened>(action)) restore_camera();
        if (std::holds_alternative<action::PixelInspected>(action)) show_inspected();
      }
      carry_out_requests();
      take_frame();
      take_photograph();
      draw();
      orders_.place(viewer_, *render_, !draws());
    }
    remember();
  }

 private:
  void set_up_viewer() {
    const FrameOptions& frame = options_.frame;
    viewer_.backend = frame.backend.value_or(available_backends().front());
    viewer_.settings.mode =
        frame.modes.front() == kReferenceMode ? kDefaultMode : frame.modes.front();
    viewer_.settings.pipeline = frame.pipeline;
    viewer_.settings.sh_degree = frame.sh_degree;
    viewer_.settings.splat_scale = frame.splat_scale;
    viewer_.settings.background = frame.background.value_or(glm::vec3(0));
    viewer_.settings.antialiased = frame.antialiased;
    viewer_.previous_mode = find_culler("3dgs");
    const auto other =
        find_variant(options_.beside.value_or(mode_name(viewer_.previous_mode)), viewer_.variant());
    if (!other) fail(ErrorKind::usage, "view: --beside: there is no '{}' here", *options_.beside);
    viewer_.split.other = *other;
    viewer_.vsync = options_.vsync && preferences_.vsync;
    viewer_.on_demand = preferences_.on_demand;
    viewer_.reduce_when_moving = preferences_.reduce_when_moving;
    viewer_.panels = preferences_.panels;
    viewer_.panels.split = options_.beside.has_value();
    viewer_.navigation = preferences_.navigation;
    viewer_.recent = preferences_.recent;
    window_.set_vsync(viewer_.vsync);
    const glm::ivec2 pixels = window_.framebuffer();
    apply(viewer_, action::Resize{pixels.x, pixels.y});
    if (!problem_.empty()) apply(viewer_, action::Say{problem_, true});
  }

  void open(const request::Open& what) {
    const bool first = what.path == options_.frame.scene;
    loader_.start(what.path, first ? options_.frame.iteration : -1,
                  first ? options_.frame.cameras : std::nullopt, what.axes);
  }

  void take_reports(Actions& actions) {
    render_->take_reports(actions);
    if (auto loaded = loader_.poll(actions)) {
      remember_camera();
      render_->run(open_scene(std::move(*loaded), viewer_.backend, viewer_.settings,
                              options_.frame.background.has_value()));
    }
    const glm::ivec2 pixels = window_.framebuffer();
    if (pixels.x != viewer_.camera.width || pixels.y != viewer_.camera.height)
      actions.push_back(action::Resize{pixels.x, pixels.y});
    if (viewer_.now - memory_measured_ > kMemorySeconds && !resting()) {
      memory_measured_ = viewer_.now;
      const bool cuda = viewer_.backend == Backend::cuda;
      actions.push_back(
          action::MemoryMeasured{process_bytes(), cuda ? gpu_bytes(options_.frame.device) : 0});
    }
  }

  // ---- requests -------------------------------------------------------------------------------
  void carry_out_requests() {
    for (const Request& request : std::exchange(viewer_.requests, {})) {
      try {
        std::visit([&](const auto& what) { carry_out(what); }, request);
      } catch (const Error& error) {
        apply(viewer_, action::Say{error.what(), true});
      }
    }
  }

  // A square of pixels, cut at the picture's edges.
  PixelBox box_around_cursor() {
    constexpr int kSide = 256;
    const glm::ivec2 size(viewer_.camera.width, viewer_.camera.height);
    const glm::ivec2 at =
        glm::clamp(glm::ivec2(glm::floor(window_.input().cursor())), glm::ivec2(0), size - 1);
    const glm::ivec2 low = glm::max(at - kSide / 2, glm::ivec2(0));
    const glm::ivec2 high = glm::min(at + kSide / 2, size);
    return {low.x, low.y, high.x, high.y};
  }

  std::string camera_name() const {
    return viewer_.dataset_camera >= 0 ? fmt::format("camera{}", viewer_.dataset_camera) : "view";
  }

  void carry_out(const request::Open& what) { open(what); }
  void carry_out(const request::CancelLoading&) {
    loader_.cancel();
    render_->stop_job();
    apply(viewer_, action::SetLoading{});
  }
  void carry_out(const request::Pick& what) {
    const glm::ivec2 pixel(glm::floor(what.pixel));
    render_->run(what.record ? record_zoom_from(order_of(viewer_), pixel, options_.out_dir)
                             : pick_pivot(order_of(viewer_), pixel));
  }
  void carry_out(const request::Screenshot& what) {
    if (what.with_ui) {
      grab_wanted_ = free_name(options_.out_dir / "screenshots",
                               fmt::format("{}_window", viewer_.scene->name), ".png");
    } else {
      render_->run(take_screenshot(order_of(viewer_), camera_name(), options_.out_dir));
    }
  }
  void carry_out(const request::CopyText& what) { window_.set_clipboard(what.text); }
  void carry_out(const request::PasteText&) {
    apply(viewer_, action::SetCamera{parse_camera(window_.clipboard(), "clipboard")});
  }
  void carry_out(const request::StopRecording&) { render_->stop_job(); }
  void carry_out(const request::Bench&) {
    render_->run(bench_view(order_of(viewer_), camera_name(), options_.out_dir));
  }
  void carry_out(const request::Inspect& what) {
    render_->run(
        inspect_view(order_of(viewer_), glm::ivec2(glm::floor(what.pixel)), what.gaussian));
  }
  void carry_out(const request::AskOracle& what) {
    render_->run(ask_oracle_about(
        order_of(viewer_), what.around_cursor ? std::optional(box_around_cursor()) : std::nullopt));
  }
  void carry_out(const request::SwitchBackend& what) { render_->run(switch_backend(what.backend)); }
  void carry_out(const request::ReadPhotograph& what) { photograph_.show(what.path); }
  void carry_out(const request::SavePath& what) {
    const std::filesystem::path path = options_.out_dir / what.path;
    write_stats(path, format_camera_path(viewer_.keyframes));
    apply(viewer_, action::Say{fmt::format("wrote {}", path.string())});
  }
  void carry_out(const request::Fullscreen&) { window_.toggle_fullscreen(); }
  void carry_out(const request::Quit&) { quit_ = true; }

  // ---- frames ---------------------------------------------------------------------------------
  void take_frame() {
    std::optional<FrameReply> reply = render_->take_frame();
    if (!reply) return;
    const ShownFrame& shown = reply->shown;
    std::optional<HeatLayer> layer;
    if (shown.heatmap) {
      memory_.heat_scale = scale_for(shown.heatmap->values);
      layer = layer_of(*shown.heatmap, memory_.heat_scale);
    } else if (shown.other && shown.other->pairs) {
      memory_.heat_scale = scale_for_signed(shown.other->pairs->values);
      layer = layer_of(*shown.other->pairs, memory_.heat_scale);
    }
    orders_.learn(*reply);
    apply(viewer_, action::FrameShown{shown});
    if (reply->texture.name != 0) {
      // OpenGL may still draw from the texture before: it rests for one more frame.
      if (resting_texture_.name != 0) gl_frames_->give_back(resting_texture_);
      resting_texture_ = std::exchange(shown_texture_, reply->texture);
    }
    presenter_.show(std::move(*reply), std::move(layer));
    draw_again();
  }

  void show_inspected() {
    memory_.construction = construction_.show(viewer_.inspected->construction);
    memory_.inspected_anew = true;
  }

  void take_photograph() try {
    if (!photograph_.reading()) return;
    photograph_.poll(memory_);
    draw_again();
  } catch (const Error& error) {
    apply(viewer_, action::Say{error.what(), true});
  }

  // ---- the window -----------------------------------------------------------------------------
  // Things that people should see: draw for a moment, and while a measurement runs just once.
  void draw_again() {
    draw_once_ = true;
    if (!measures()) draw_until_ = glfwGetTime() + kUiSeconds;
  }

  void note_change(const Action& action) {
    const bool silent = std::holds_alternative<action::Tick>(action) ||
                        std::holds_alternative<action::MeasuringChanged>(action) ||
                        std::holds_alternative<action::MemoryMeasured>(action);
    if (!silent) draw_again();
  }

  // Drawing the window takes time from what the GPU or the CPU is measured with.
  bool measures() const { return viewer_.measuring || viewer_.zoom.running; }

  bool draws() const {
    const double now = glfwGetTime();
    if (draw_once_ || window_.seconds_since_event() < kUiSeconds) return true;
    return now < draw_until_ || !viewer_.on_demand || viewer_.loading || viewer_.playback.running ||
           now - viewer_.last_motion < 0.2;
  }

  // In continuous drawing, frame and window take turns on the GPU, so that the frame's time is its
  // own; a slow frame does not stop the window.
  bool frame_comes_first() {
    return !viewer_.on_demand && !viewer_.loading && render_->busy() &&
           glfwGetTime() - last_draw_ < kFramePatience;
  }

  bool resting() {
    return !draws() && script_.done() && !window_.input().busy() && orders_.are_placed(viewer_) &&
           glfwGetTime() - viewer_.last_motion > kMovedSeconds && !numbers_are_missing(viewer_);
  }

  void draw() {
    if (viewer_.toasts.size() != toasts_) draw_once_ = true;
    toasts_ = viewer_.toasts.size();
    if (!draws() || frame_comes_first()) return;
    if (viewer_.measuring && !draw_once_) render_->drop_numbers();
    draw_once_ = false;
    const double now = glfwGetTime();
    if (viewer_.vsync != vsync_) window_.set_vsync(vsync_ = viewer_.vsync);
    const glm::ivec2 pixels = window_.framebuffer();
    memory_.cursor = window_.input().cursor();
    Actions actions;
    window_.begin_ui();
    draw_panels(viewer_, memory_, actions);
    presenter_.draw(pixels.x, pixels.y, viewer_.split);
    window_.end_ui();
    grab(pixels);
    window_.swap();
    if (!viewer_.on_demand) Presenter::finish();
    measure_window(now);
    for (const Action& action : actions) apply(viewer_, action);
    if (!actions.empty()) draw_again();
    title();
  }

  void grab(glm::ivec2 pixels) {
    if (grab_wanted_.empty()) return;
    const std::filesystem::path path = std::exchange(grab_wanted_, {});
    try {
      std::error_code ignored;
      std::filesystem::create_directories(path.parent_path(), ignored);
      write_image(Presenter::grab(pixels.x, pixels.y), path);
      if (script_.done()) apply(viewer_, action::Say{fmt::format("wrote {}", path.string())});
    } catch (const Error& error) {
      apply(viewer_, action::Say{error.what(), true});
    }
  }

  void measure_window(double now) {
    const double seconds = now - last_draw_;
    last_draw_ = now;
    // A pause is no frame rate.
    const double fps = seconds > 0 && seconds < 0.25 ? 1 / seconds : 0;
    display_fps_ = fps == 0 ? 0 : display_fps_ == 0 ? fps : 0.9 * display_fps_ + 0.1 * fps;
    const bool steady = !viewer_.on_demand || viewer_.moving() || viewer_.loading;
    apply(viewer_, action::WindowMeasured{steady ? display_fps_ : 0, presenter_.gpu_ms()});
  }

  void title() {
    const std::string text = viewer_.scene ? viewer_.scene->name + " - quadsplat" : "quadsplat";
    if (text != title_) window_.set_title(title_ = text);
  }

  // ---- scripts ----------------------------------------------------------------------------------
  bool at_rest() {
    if (loader_.busy() || viewer_.loading || render_->busy() || photograph_.reading()) return false;
    if (!viewer_.scene) return true;
    const bool drawn = viewer_.version == viewer_.shown.version && viewer_.shown.divisor == 1;
    return drawn && !numbers_are_missing(viewer_) && !viewer_.measuring && !viewer_.moving() &&
           !viewer_.playback.running && !viewer_.zoom.running;
  }

  void play_script(Actions& actions) {
    if (!grab_wanted_.empty()) return;
    const auto step = script_.next(viewer_.now, [this] { return at_rest(); });
    if (!step) return;
    if (step->command == "shot") {
      grab_wanted_ = step->words[0];
    } else if (step->command == "state") {
      write_stats(step->words[0], state_json(viewer_));
    } else if (step->command == "quit") {
      quit_ = true;
    } else {
      window_.play(*step, viewer_.now, actions);
    }
    draw_again();
  }

  // ---- what is kept -----------------------------------------------------------------------------
  // Where this scene was left, unless the command line names cameras.
  void restore_camera() {
    const auto kept = preferences_.cameras.find(viewer_.scene->path.string());
    if (kept == preferences_.cameras.end() || options_.frame.cameras) return;
    try {
      apply(viewer_, action::SetCamera{parse_camera(kept->second, "settings")});
      apply(viewer_, action::Say{"the view of last time; Home goes to the first view"});
    } catch (const Error&) {  // kept by hand: the first view will do
    }
  }

  void remember_camera() {
    if (viewer_.scene)
      preferences_.cameras[viewer_.scene->path.string()] = format_camera(viewer_.camera);
  }

  void remember() {
    remember_camera();
    const glm::ivec2 size = window_.windowed_size();
    preferences_.width = size.x;
    preferences_.height = size.y;
    preferences_.vsync = viewer_.vsync;
    preferences_.on_demand = viewer_.on_demand;
    preferences_.reduce_when_moving = viewer_.reduce_when_moving;
    preferences_.panels = viewer_.panels;
    preferences_.navigation = viewer_.navigation;
    preferences_.recent = viewer_.recent;
    write_preferences(options_.settings, preferences_);
  }

  const ViewOptions& options_;
  std::string problem_;  // of the preferences
  Preferences preferences_;
  Window window_;
  Presenter presenter_;
  PhotographTexture photograph_;
  PictureTexture construction_;
  std::optional<GlFrames> gl_frames_;
  SceneLoader loader_;
  std::optional<RenderThread> render_;
  Viewer viewer_;
  PanelMemory memory_;

  ScriptPlayer script_;
  FrameOrders orders_;
  GlTexture shown_texture_, resting_texture_;
  std::filesystem::path grab_wanted_;
  bool quit_ = false, vsync_ = true, draw_once_ = true;
  std::size_t toasts_ = 0;
  double draw_until_ = 0, last_draw_ = 0, display_fps_ = 0, memory_measured_ = -10;
  std::string title_;
};

}  // namespace

void run_viewer(const ViewOptions& options) { ViewLoop(options).run(); }

}  // namespace qs
