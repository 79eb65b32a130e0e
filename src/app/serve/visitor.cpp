// SPDX-License-Identifier: MIT
#include "app/serve/visitor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/serve/served_commands.h"
#include "app/viewer/commands/controls.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/edit_actions.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/samples.h"
#include "app/viewer/state/training_actions.h"
#include "app/viewer/state/zoom_actions.h"
#include "base/fail.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

constexpr std::size_t kMostJobs = 4;         ///< of a visitor that wait
constexpr std::size_t kMostFiles = 4;        ///< that wait to be sent
constexpr std::size_t kMostKeyframes = 500;  ///< of a path
constexpr double kRestSeconds = 0.03;        ///< without motion, before the picture at rest is made
constexpr double kMostVideoPixels = 1920 * 1200;  ///< an encoder for 4096x4096 has 1.1 GB
constexpr double kLongestTick = 0.1;  ///< seconds; a longer pause does not let the camera jump

Viewer first_viewer(const OpenedScene& scene, glm::ivec2 size) {
  Viewer viewer;
  viewer.camera.width = size.x;
  viewer.camera.height = size.y;
  viewer.settings.mode = scene.settings.mode;
  viewer.animates_moves = true;
  viewer.is_remote = true;
  return viewer;
}

int video_divisor(const Camera& camera) {
  const double pixels = static_cast<double>(camera.width) * camera.height;
  return static_cast<int>(std::ceil(std::sqrt(pixels / kMostVideoPixels)));
}

Actions actions_of(const Viewer& v, const message::SetControl& set) {
  const Control* const control = find_control(set.control);
  if (control == nullptr) return {};
  const auto action = set_control(v, *control, set.value, set.index);
  return action ? Actions{*action} : Actions{};
}

Actions actions_of(const Viewer& v, const message::DragHandle& drag) {
  if (!v.panels.crop || !v.crop.wish.boxed) return {};
  CropWish moved = v.crop.wish;
  const auto box = dragged(moved.box, drag.face, v.camera, drag.at);
  if (!box) return {};
  moved.box = *box;
  return {call(action::change_crop, moved)};
}

Actions actions_of(const Viewer& v, const message::ShowPanels& panels) {
  Actions actions;
  for (const KeyCommand* command : served_commands()) {
    if (command->panel == nullptr) continue;
    const bool opens = std::ranges::count(panels.open, command->help) > 0;
    if (opens != v.panels.*command->panel) actions.push_back(command->action);
  }
  return actions;
}

}  // namespace

bool VisitorHost::has_room() const { return jobs_.size() + open_ < kMostJobs; }

void VisitorHost::keep(VisitorJob job) {
  if (!has_room()) fail("too much is asked for at once: try again when some of it is done");
  jobs_.push_back(std::move(job));
}

void VisitorHost::send_file(const std::string& name, std::shared_ptr<const std::string> bytes) {
  if (files_.size() >= kMostFiles) fail("too many files wait to be sent: try again later");
  files_.push_back({harmless_name(name), std::move(bytes)});
}

// The run is stopped at the terminal only.
void VisitorHost::train(TrainingCommand command) {
  if (command == TrainingCommand::stop) refuse();
  training_commands_.push_back(command);
}

void VisitorHost::refuse() { fail("this is not possible in a browser"); }

Visitor::Visitor(const std::vector<const OpenedScene*>& scenes, glm::ivec2 size, double now)
    : scenes_(scenes), store_(first_viewer(*scenes.front(), size)), began_(now), last_tick_(now) {
  show_scene(0);
}

void Visitor::show_scene(std::size_t scene) {
  if (scene >= scenes_.size()) return;
  if (viewer().crop.busy || viewer().editing.busy) {  // its outcome is of this scene
    return store_.apply(
        call(action::notify, std::string("the crop is not finished: choose the scene again")),
        host_);
  }
  stop_long_jobs();
  scene_ = scene;
  met_ = {{}, scenes_[scene]->backend};
  store_.apply(call(action::scene_opened, *scenes_[scene]), host_);
}

// A zoom that has not begun will not, and does not report its end.
void Visitor::stop_long_jobs() {
  host_.stop_job();
  store_.apply(call(action::zoom_job_ended), host_);
}

void Visitor::show_view(const message::ShowView& view) {
  if (view.scene != scene_) show_scene(view.scene);
  if (view.scene != scene_) return;
  const CullMode mode = find_culler(view.mode);
  if (mode >= 1) store_.apply(call(action::set_mode, mode), host_);
  store_.apply(
      [&](Viewer& viewer, Host&) { action::set_camera(viewer, parse_camera(view.camera, "view")); },
      host_);
}

// The actions, and the jobs that a change of the crop needs.
void Visitor::do_all(const Actions& actions) {
  for (const Action& action : actions) store_.apply(action, host_);
  if (viewer().keyframes.size() > kMostKeyframes)
    store_.apply(call(action::remove_keyframe, kMostKeyframes), host_);
  if (host_.has_room()) store_.apply(call(action::follow_edits), host_);
}

void Visitor::apply(const Actions& actions, double now) {
  tick(now);
  do_all(actions);
}

void Visitor::tick(double now) {
  Actions actions;
  input_.tick(actions);
  for (const Action& action : actions) store_.apply(action, host_);
  const Turn turn{.now = now - began_,
                  .cursor = input_.picture_cursor(),
                  .measuring = measuring_ == Measuring::runs,
                  .bare_size = size_of(viewer().camera)};
  const double seconds = std::clamp(now - last_tick_, 0.0, kLongestTick);
  last_tick_ = now;
  store_.apply(call(action::tick, turn, seconds), host_);
}

void Visitor::take(const ClientMessage& message, double now) {
  tick(now);
  if (message.input != 0) last_input_ = message.input;
  Actions actions;
  const double moment = now - began_;
  const auto move_cursor = [&](glm::dvec2 at) { input_.cursor(at, viewer().navigation, actions); };
  const auto& body = message.body;
  if (const auto* resize = std::get_if<message::Resize>(&body))
    actions.push_back(call(action::resize, resize->size.x, resize->size.y));
  if (const auto* key = std::get_if<message::Key>(&body))
    if (key->key != 0 && (!key->down || may_press(key->key, key->mods)))
      input_.key(key->key, key->down, key->repeat, key->mods, false, actions);
  if (const auto* button = std::get_if<message::Button>(&body)) {
    move_cursor(button->at);
    input_.button(button->button, button->down, false, moment, actions);
  }
  if (const auto* cursor = std::get_if<message::Cursor>(&body)) move_cursor(cursor->at);
  if (const auto* wheel = std::get_if<message::Wheel>(&body))
    input_.wheel(wheel->notches, wheel->mods, false, actions);
  if (const auto* command = std::get_if<message::Command>(&body)) {
    const KeyCommand* const row = find_served_command(command->help);
    if (row != nullptr && !row->on_release) actions.push_back(row->action);
  }
  if (const auto* scene = std::get_if<message::ShowScene>(&body)) show_scene(scene->scene);
  if (const auto* video = std::get_if<message::Video>(&body))
    quality_.decodes_video(video->decodes);
  if (const auto* set = std::get_if<message::SetControl>(&body))
    actions = actions_of(viewer(), *set);
  if (const auto* drag = std::get_if<message::DragHandle>(&body))
    actions = actions_of(viewer(), *drag);
  if (const auto* view = std::get_if<message::ShowView>(&body)) show_view(*view);
  if (const auto* panels = std::get_if<message::ShowPanels>(&body))
    actions = actions_of(viewer(), *panels);
  if (const auto* file = std::get_if<message::OpenFile>(&body))
    actions.push_back([file = *file](Viewer& v, Host& host) {
      if (file.name.ends_with(".edits.json"))
        return action::open_edits(v, host, file.name, file.text);
      if (file.name.ends_with(".measures.json"))
        return action::open_measures(v, host, file.name, file.text);
      action::notify(v, file.name + ": only files .edits.json and .measures.json are opened here");
    });
  if (std::holds_alternative<message::Stop>(body)) stop_long_jobs();
  if (std::holds_alternative<message::Blur>(body)) input_.release_all(actions);
  do_all(actions);
}

// While a model is trained, the next picture replaces this one soon: no exact picture is made.
bool Visitor::waits_for_rest() const {
  return viewer().version != ordered_version_ || !(ordered_lossless_ || is_training(viewer()));
}

bool Visitor::is_moved() const {
  const Viewer& v = viewer();
  return input_.busy() || v.travel || v.flight.velocity != glm::dvec3(0) || v.playback.running;
}

bool Visitor::is_busy() const {
  const Viewer& v = viewer();
  return is_moved() || !v.toasts.empty() || !v.still() ||
         (waits_for_rest() && (!rests() || !may_draw(v)));
}

// Sooner than in the window: input cancels the picture at rest.
bool Visitor::rests() const { return viewer().now - viewer().last_motion > kRestSeconds; }

std::optional<PictureOrder> Visitor::next_order(const LineSpeed& line) {
  const Viewer& v = viewer();
  if (!waits_for_rest() || !may_draw(v)) return {};
  const bool is_new = v.version != ordered_version_;
  if (!is_new && (!rests() || is_moved())) return {};
  PictureOrder order;
  order.scene = scene_;
  order.request = full_frame(v);
  order.request.moving = is_new && v.moving();
  order.input = last_input_;
  order.lossless = !is_new;
  order.encoding = quality_.next(line);
  if (order.request.moving && v.backend == Backend::cpu && v.reduce_when_moving)
    order.request.divisor = resolution_.divisor();
  if (is_new) order.request.divisor = std::max(order.request.divisor, quality_.divisor());
  if (is_new && order.encoding.codec == PictureCodec::vp9)
    order.request.divisor = std::max(order.request.divisor, video_divisor(v.camera));
  if (order.request.other) order.split = v.split;
  if (shows_counts(v) && !counts_are_current(v) &&
      (counting_pace_.counts_next() || !order.request.moving))
    order.request.counted = CountedView{counted_camera(v), order.request.settings};
  order.request.pairs = is_new && wants_pairs(v, order.request);
  order.request.settings.occlusion = may_occlude(v, order.request);
  ordered_version_ = v.version;
  ordered_lossless_ = order.lossless;
  return order;
}

MeasuringWish Visitor::measuring_wish() {
  const Viewer& v = viewer();
  const bool wants = numbers_are_wanted(v) && v.still() && !is_moved();
  MeasuringWish wish;
  if (asked_numbers_ >= 0) {
    if (wants && asked_numbers_ == v.view_version) return wish;
    wish.stops = true;
    asked_numbers_ = -1;
    measuring_ = Measuring::none;
  }
  if (!wants) return wish;
  asked_numbers_ = v.view_version;
  measuring_ = Measuring::waits;
  wish.request = NumbersRequest{measured_camera(v), full_frame(v).settings, v.view_version,
                                numbers_are_current(v)};
  return wish;
}

void Visitor::measuring_changed(int version, Measuring state, double now) {
  if (version != asked_numbers_) return;
  measuring_ = state;
  if (state == Measuring::none) asked_numbers_ = -1;
  tick(now);
}

void Visitor::picture_ready(const Picture& picture, double now) {
  if (!picture.error.empty()) {
    apply({call(action::notify_error, picture.error)}, now);
    return;
  }
  if (picture.encoded.bytes.empty()) {  // cancelled
    if (picture.order.request.version == ordered_version_) ordered_lossless_ = false;
    return;
  }
  resolution_.learn(picture.shown.divisor, cost_of(picture.shown));
  if (!picture.order.lossless) quality_.learn(picture.encoded, picture.shown.divisor);
  counting_pace_.learn(picture.shown.stats, !picture.shown.mode_pairs.empty());
  apply({call(action::frame_shown, picture.shown)}, now);
}

void pass_on_work(Visitor& visitor, int number, Pictures& pictures) {
  if (visitor.host().take_stop()) pictures.stop_long(number);
  const std::size_t scene = visitor.scene();
  for (VisitorJob& work : visitor.host().take_jobs()) {
    if (work.is_long) {
      pictures.run_long(number, scene, std::move(work.job));
    } else {
      pictures.run(number, scene, std::move(work.job));
    }
  }
  const MeasuringWish wish = visitor.measuring_wish();
  if (wish.stops) pictures.stop_measuring(number);
  if (wish.request) pictures.measure({number, scene, *wish.request});
}

}  // namespace qs
