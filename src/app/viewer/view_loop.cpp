// SPDX-License-Identifier: MIT
#include <algorithm>

#include <GLFW/glfw3.h>

#include "app/remote/remote_training.h"
#include "app/viewer/memory_use.h"
#include "app/viewer/pacing.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/preferences.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/render/panel_pictures.h"
#include "app/viewer/render/scene_opening.h"
#include "app/viewer/render/training_thread.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/edit_actions.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/kept_work.h"
#include "app/viewer/state/layout.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/training_actions.h"
#include "app/viewer/view_options.h"
#include "app/viewer/window/desktop.h"
#include "app/viewer/window/input_script.h"
#include "app/viewer/window/presenter.h"
#include "app/viewer/window/window.h"
#include "base/assets.h"
#include "base/fail.h"
#include "base/quit_signals.h"
#include "io/bytes/replace_file.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

constexpr double kLongestTurn = 0.1;  ///< seconds: a longer one does not make the camera jump
constexpr int kWide = 1280;  ///< screen units: such a window shows FPS of all modes at first
constexpr double kMemorySeconds = 1;  ///< between two measurements of memory

glm::ivec2 size_of(const PixelBox& box) { return {box.x1 - box.x0, box.y1 - box.y0}; }

std::filesystem::path first_scene(const ViewOptions& options) {
  if (options.train || options.connect) return "";
  if (!options.frame.scene.empty() || !first_start(options)) return options.frame.scene;
  return find_asset(kBundledScene).value_or("");
}

// True if the window's size and scale do not depend on the screen.
bool is_fixed(const ViewOptions& options) { return options.script || options.frame.size; }

class ViewLoop final : public Host {
 public:
  explicit ViewLoop(const ViewOptions& options)
      : options_(options),
        store_(initial_viewer(options, first_size_)),
        opening_(Window::wake, options.frame.threads),
        photographs_(Window::wake),
        test_photographs_(Window::wake),
        window_(begin_reading(), is_fixed(options) ? first_size_ : glm::ivec2(0)) {
    if (options.script) {
      script_ = ScriptPlayer(*options.script);
    } else {
      desktop_dialog_.emplace(Window::wake);  // scripts use the viewer's own dialog
    }
    if (options.interop && viewer_.backend == Backend::cuda) gl_frames_.emplace(window_.handle());
    render_.emplace(options.frame, Window::wake, gl_frames_ ? &*gl_frames_ : nullptr);
    if (options.train) training_.emplace(Window::wake, options.train);
    window_.set_vsync(vsync_ = viewer_.vsync);
    follow_scale();
    if (first_start(options) && !options.script && window_.size().x >= kWide)
      apply(action::toggle_panel, &Panels::hud);
    const glm::ivec2 pixels = size_of(picture_area());
    apply(action::resize, pixels.x, pixels.y);
    if (options.connect) {
      apply(action::remote_opened, options.connect->text, options.remote_cameras);
      remote_.emplace(*options.connect, Window::wake);
    }
  }

  void run_until_quit() {
    while (!quit_) {
      Actions actions;
      window_.poll(pacing_.sleep_seconds(viewer_, surroundings(), numbers_are_wanted(viewer_)),
                   viewer_.navigation, actions);
      if (QuitSignals::arrived()) quit();
      if (window_.close_requested())
        actions.push_back(call(action::leave, std::filesystem::path()));
      const double now = glfwGetTime(), seconds = std::min(now - viewer_.now, kLongestTurn);
      play_script(actions);
      window_.input().tick(actions);
      if (!options_.script) window_.read_gamepad(seconds, actions);
      render_->take_reports(actions);
      opening_.take_reports(actions);
      photographs_.take_reports(actions);
      test_photographs_.take_reports(actions);
      if (training_) training_->take_reports(actions);
      if (desktop_dialog_) desktop_dialog_->take_reports(actions);
      desktop_programs_.take_reports(actions);
      measure_memory();
      turn_.now = now;
      turn_.cursor = window_.input().picture_cursor();
      turn_.measuring = render_->measuring();
      turn_.bare_size = size_of(picture_area(false));
      apply(action::tick, turn_, seconds);
      apply_all(actions);
      prefer_desktop_dialog();
      follow_scale();
      fit_picture();
      follow_training();
      follow_remote();
      apply(action::follow_edits);
      apply(action::follow_view_choice);
      apply(action::follow_test_view);
      apply(action::follow_photograph);
      apply(action::follow_measures);
      begin_beside();
      take_frame();
      // The CPU draws the next frame while the window shows this frame, a GPU afterwards.
      if (viewer_.moving() && viewer_.backend == Backend::cpu) request_frames();
      draw();
      request_frames();
    }
    apply(action::keep_work);
    write_preferences(options_.settings, viewer_, window_.windowed_size());
  }

 private:
  // ---- Host -----------------------------------------------------------------------------------
  void open(const std::filesystem::path& path, const std::string& axes) override {
    require_scene();
    stop_zoom();
    opening_.open(request_to_open(path, axes));
  }
  void open_beside(const std::filesystem::path& path) override {
    require_scene();
    stop_zoom();
    opening_.open({.path = path,
                   .axes = remembered_axes(viewer_, path),
                   .skip_huge = viewer_.skips_huge,
                   .beside = true});
  }
  void read_photograph(const std::filesystem::path& path) override {
    photographs_.read(read_camera_photograph(path));
  }
  void read_test_photograph(const std::shared_ptr<const TestViews>& views,
                            std::size_t view) override {
    test_photographs_.read(qs::read_test_photograph(views, view));
  }
  void cancel_loading() override {
    opening_.cancel();
    render_->stop_job();
    if (training_ && training_->reads()) training_->command(TrainingCommand::stop);
  }
  void run(Job job) override {
    require_scene();
    render_->run(std::move(job));
  }
  void stop_job() override { render_->stop_job(); }
  void leave_job(bool keeps) override { render_->stop_job(keeps); }
  void save_results(const std::filesystem::path& folder) override {
    render_->run([folder](RenderContext& context) { context.save_unsaved(folder); });
  }
  void run_behind(Job job) override {
    if (!remote_) render_->run_behind(std::move(job));
  }
  void start_training(const TrainingRequest& request) override {
    require_scene();
    stop_zoom();
    training_shown_ = false;
    training_.emplace(Window::wake, [this, request](TrainingThread& thread) {
      return options_.train_request(thread, request);
    });
  }
  void train(TrainingCommand command) override {
    if (remote_) remote_->pause(command == TrainingCommand::pause);
    if (training_) training_->command(command);
  }
  void write_file(const std::filesystem::path& path, const std::string& text) override {
    write_text(path, text);
  }
  void grab_window(const std::filesystem::path& path, bool notify) override {
    grab_.request(path, notify);
    pacing_.note_change(viewer_, glfwGetTime());
  }
  void grab_picture(const std::filesystem::path& path) override {
    if (remote_picture_.rgba.empty()) fail("there is no picture of the training yet");
    WindowGrab grab;
    Actions actions;
    grab.request(path, true);
    grab.take([&p = remote_picture_] { return image_of(p.rgba, p.width, p.height); }, actions);
    apply_all(actions);
  }
  void open_with_desktop(const std::filesystem::path& path) override {
    desktop_programs_.open(path);
  }
  std::string clipboard() const override { return window_.clipboard(); }
  void set_clipboard(const std::string& text) override { window_.set_clipboard(text); }
  bool copy_picture(const std::filesystem::path& file) override { return qs::copy_picture(file); }
  void toggle_fullscreen() override { window_.toggle_fullscreen(); }
  void quit() override { quit_ = true; }

  void require_scene() const { qs::require_scene(viewer_); }

  // Reading and training would disturb the frames that the recorder times.
  void stop_zoom() {
    if (viewer_.zoom.running) render_->stop_job(true);
  }

  OpenRequest request_to_open(const std::filesystem::path& path, const std::string& axes) const {
    const FrameOptions& frame = options_.frame;
    OpenRequest request{.path = path,
                        .axes = axes.empty() ? remembered_axes(viewer_, path) : axes,
                        .up = frame.up ? frame.up : remembered_up(viewer_, path),
                        .keep_background = frame.background.has_value(),
                        .skip_huge = viewer_.skips_huge,
                        .streams = frame.levels.streams()};
    if (path == frame.scene) {
      request.iteration = frame.iteration;
      request.cameras_file = frame.cameras;
      request.edits = frame.edits;
    }
    return request;
  }

  // Opening a window takes as long as reading a scene of moderate size. Returns the window's size.
  // The constructor calls it before the window exists, so it reads no member below the window.
  glm::ivec2 begin_reading() {
    const std::filesystem::path scene = first_scene(options_);
    if (!scene.empty()) opening_.open(request_to_open(scene, options_.frame.axes));
    return first_size_;
  }

  // ---- one turn -------------------------------------------------------------------------------
  template <class Function, class... Arguments>
  void apply(Function function, Arguments... arguments) {
    store_.apply(call(function, std::move(arguments)...), *this);
  }

  void apply_all(const Actions& actions) {
    for (const Action& action : actions) store_.apply(action, *this);
    if (!actions.empty()) pacing_.note_change(viewer_, glfwGetTime());
  }

  Surroundings surroundings() {
    const bool wants_picture =
        remote_ ? asked_version_ != viewer_.version : !requests_.are_up_to_date(viewer_);
    const bool pending = !script_.done() || window_.input().busy() || wants_picture;
    return {glfwGetTime(), window_.last_event(), render_->busy(), pending};
  }

  // The part of the framebuffer for the picture.
  PixelBox picture_area(bool with_bars = true) const {
    const glm::vec2 per_unit =
        glm::vec2(window_.framebuffer()) / glm::max(glm::vec2(1), glm::vec2(window_.size()));
    const Layout layout = layout_of(viewer_, window_.metrics());
    const Rect picture = with_bars ? layout.picture : layout.between_lines();
    const glm::ivec2 low(glm::round(picture.low * per_unit));
    const glm::ivec2 high(glm::round(picture.high * per_unit));
    return {low.x, low.y, high.x, high.y};
  }

  // Shows the desktop's dialog instead of the viewer's own dialog, if it is available.
  void prefer_desktop_dialog() {
    const bool was_open = std::exchange(dialog_open_, viewer_.panels.open);
    const Choosing choosing = viewer_.choosing;
    if (was_open || !dialog_open_ || !desktop_dialog_ || !desktop_dialog_->is_available(choosing))
      return;
    apply(action::toggle_panel, &Panels::open);
    dialog_open_ = false;
    std::error_code error;
    const std::filesystem::path beside = viewer_.scene ? viewer_.scene->path.parent_path() : ".";
    desktop_dialog_->show(std::filesystem::absolute(beside, error), choosing);
  }

  void follow_scale() {
    turn_.screen_scale = window_.screen_scale();
    if (viewer_.screen_scale != turn_.screen_scale)
      apply([scale = turn_.screen_scale](Viewer& viewer) { viewer.screen_scale = scale; });
    window_.set_scale(interface_scale(viewer_), viewer_.light_theme);
  }

  void fit_picture() {
    const PixelBox area = picture_area();
    window_.input().set_picture_origin({area.x0, area.y0});
    const glm::ivec2 pixels = size_of(area);
    if (pixels != glm::ivec2(viewer_.camera.width, viewer_.camera.height))
      apply_all({call(action::resize, pixels.x, pixels.y)});
  }

  void play_script(Actions& actions) {
    if (grab_.requested()) return;
    const auto at_rest = [&] {
      return is_settled(viewer_) && !opening_.busy() && !photographs_.busy() && !render_->busy() &&
             beside_.empty() && !test_photographs_.busy() && !test_view_is_pending(viewer_) &&
             !photograph_is_pending(viewer_) &&
             !(remote_ && viewer_.shown.version != viewer_.version) &&
             !(training_ && (training_->busy() || training_->reads()));
    };
    const auto step = script_.next(viewer_, *this, at_rest);
    if (step) window_.play(*step, viewer_.now, actions);
    if (step) pacing_.note_change(viewer_, glfwGetTime());
  }

  // Shows the trainer's models: the first model opens as a scene, later models replace it.
  void follow_training() {
    if (!training_ || !viewer_.training) return;
    if (const std::optional<TrainedModel> model = training_->take_model()) {
      if (training_shown_) return render_->run(show_model(*model));
      training_shown_ = true;
      return render_->run(open_trained(*model, viewer_.backend, viewer_.settings));
    }
    const bool shows_newest = viewer_.scene && viewer_.shown.version == viewer_.version;
    if (is_training(viewer_) && shows_newest && may_draw(viewer_) && !render_->busy() &&
        viewer_.scene->path == viewer_.training->folder)
      training_->want_model();
  }

  // Passes the view to the training in another program, and its facts to the viewer.
  void follow_remote() {
    if (!remote_) return;
    RemoteRun run = remote_->run();
    if (run != *viewer_.remote) apply_all({call(action::remote_reported, run)});
    // A view that moved is asked for once more when it rests.
    if (asked_version_ == viewer_.version && asked_moving_ == viewer_.moving()) return;
    asked_version_ = viewer_.version;
    asked_moving_ = viewer_.moving();
    remote_->show({viewer_.camera, viewer_.version,
                   static_cast<double>(viewer_.settings.splat_scale), asked_moving_});
  }

  void take_remote_picture() {
    std::optional<RemotePicture> picture = remote_->take_picture();
    if (!picture) return;
    RenderedFrame frame;
    frame.shown.mode = viewer_.mode();
    frame.shown.version = picture->version;
    frame.shown.camera = picture->camera;
    frame.shown.stats.frame_ms = static_cast<float>(picture->ms);
    frame.width = picture->width;
    frame.height = picture->height;
    frame.rgba = picture->rgba;
    remote_picture_ = std::move(*picture);
    apply_all({call(action::frame_shown, frame.shown)});
    presenter_.show(std::move(frame), nullptr);
  }

  // Reads the second scene that the command line names, after the first scene.
  void begin_beside() {
    if (beside_.empty() || opening_.busy() || photographs_.busy() || render_->busy()) return;
    const std::filesystem::path path = std::exchange(beside_, {});
    if (viewer_.scene) open_beside(path);
  }

  void measure_memory() {
    if (viewer_.now - memory_measured_ < kMemorySeconds ||
        pacing_.rests(viewer_, surroundings(), numbers_are_wanted(viewer_)))
      return;
    memory_measured_ = viewer_.now;
    const bool cuda = viewer_.backend == Backend::cuda;
    turn_.process_bytes = process_bytes();
    if (cuda) gpu_memory_.ask();
    turn_.gpu_bytes = cuda ? gpu_memory_.bytes() : 0;
  }

  void take_frame() {
    if (remote_) return take_remote_picture();
    std::optional<RenderedFrame> frame = render_->take_frame();
    if (!viewer_.scene && !viewer_.loading) return presenter_.clear();
    if (!frame) return;
    if (viewer_.scene) requests_.learn(*frame);
    apply_all({call(action::frame_shown, frame->shown)});
    presenter_.show(std::move(*frame), gl_frames_ ? &*gl_frames_ : nullptr);
  }

  void request_frames() {
    if (remote_) return;
    const bool rests = !pacing_.wants_to_draw(viewer_, surroundings());
    render_->note_rest(rests);
    requests_.update(viewer_, *render_, rests);
  }

  void draw() {
    const Surroundings around = surroundings();
    if (!pacing_.wants_to_draw(viewer_, around) || pacing_.frame_comes_first(viewer_, around))
      return;
    render_->note_drawing();
    if (pacing_.begin_drawing(viewer_)) render_->cancel_numbers();
    if (viewer_.vsync != vsync_) window_.set_vsync(vsync_ = viewer_.vsync);
    window_.set_title(window_title(viewer_));
    panel_state_.photograph = photograph_.show(viewer_.photograph.image);
    if (viewer_.training) {
      const TestView& test_view = viewer_.training->test_view;
      panel_state_.test_photograph = test_photograph_.show(test_view.shown);
      panel_state_.test_picture = test_picture_.show(test_view.comparison.picture);
    }
    panel_state_.candidates = candidates_.show(viewer_.view_choice.pictures);
    show_thumbnail();
    turn_.drawn_status = hud_status(viewer_);
    const glm::ivec2 pixels = window_.framebuffer();
    Actions actions;
    window_.show_names(viewer_, panel_state_.chooser);
    window_.begin_ui();
    draw_panels(viewer_, panel_state_, actions);
    HeatStyle style = viewer_.heat_view.style;
    if (awaited_map(viewer_)) style.opacity = 0;  // the picture has another map
    presenter_.draw(pixels, picture_area(), shown_split(viewer_), style);
    window_.end_ui();
    turn_.drawn_columns = panel_state_.columns;
    grab_.take([&] { return Presenter::grab(pixels.x, pixels.y); }, actions,
               alterations_of(viewer_).text);
    window_.swap();
    if (!viewer_.on_demand || viewer_.zoom.running) Presenter::finish();
    turn_.display_fps = pacing_.end_drawing(viewer_, around.now);
    turn_.present_ms = presenter_.gpu_ms();
    apply_all(actions);
  }

  // Shows the thumbnail of the welcome panel, which is drawn without a scene.
  void show_thumbnail() {
    if (viewer_.scene || viewer_.loading) return;
    if (const auto file = bundled_picture_ ? std::nullopt : find_asset(kBundledPicture))
      bundled_picture_ = std::make_shared<Image>(read_image(*file));
    panel_state_.thumbnail = thumbnail_.show(bundled_picture_);
    if (bundled_picture_)
      panel_state_.thumbnail_aspect = static_cast<float>(bundled_picture_->width) /
                                      static_cast<float>(bundled_picture_->height);
  }

  const ViewOptions& options_;
  std::filesystem::path beside_ = options_.beside_scene;  // until it is being read
  const QuitSignals quit_signals_;
  // the window's first size; 0: chosen by the screen
  glm::ivec2 first_size_{options_.script ? glm::ivec2(1280, 720) : glm::ivec2(0)};
  ViewerStore store_;
  const Viewer& viewer_ = store_.viewer();
  Turn turn_;
  SceneOpening opening_;
  PhotographReader photographs_, test_photographs_;
  Window window_;
  Presenter presenter_;
  std::shared_ptr<const Image> bundled_picture_;
  PictureTexture photograph_, thumbnail_, candidates_, test_photograph_, test_picture_;
  std::optional<GlFrames> gl_frames_;
  std::optional<RenderThread> render_;
  PanelState panel_state_;
  Pacing pacing_;
  ScriptPlayer script_;
  FrameRequests requests_;
  WindowGrab grab_;
  std::optional<DesktopDialog> desktop_dialog_;
  DesktopPrograms desktop_programs_;
  std::optional<TrainingThread> training_;  // it ends first, and saves the model
  bool training_shown_ = false;
  std::optional<RemoteTraining> remote_;
  RemotePicture remote_picture_;  // its last picture
  int asked_version_ = -1;        // the version of the last view
  bool asked_moving_ = false;     // that view
  bool quit_ = false, vsync_ = true, dialog_open_ = false;
  double memory_measured_ = -10;
  MemoryWatch gpu_memory_{[device = options_.frame.device] { return gpu_bytes(device); }};
};

}  // namespace

void run_viewer(const ViewOptions& options) { ViewLoop(options).run_until_quit(); }

}  // namespace qs
