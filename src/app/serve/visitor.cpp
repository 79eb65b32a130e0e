// SPDX-License-Identifier: MIT
#include "app/serve/visitor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/serve/served_commands.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

constexpr std::size_t kMostJobs = 4;  ///< of a visitor that wait
constexpr double kRestSeconds = 0.1;  ///< without motion, before the picture at rest is made
constexpr double kMostVideoPixels = 1920 * 1200;  ///< an encoder for 4096x4096 has 1.1 GB
constexpr double kLongestTick = 0.1;  ///< seconds; a longer pause does not let the camera jump

Viewer first_viewer(const OpenedScene& scene, glm::ivec2 size) {
  Viewer viewer;
  viewer.camera.width = size.x;
  viewer.camera.height = size.y;
  viewer.settings.mode = scene.settings.mode;
  viewer.animates_moves = true;
  return viewer;
}

int video_divisor(const Camera& camera) {
  const double pixels = static_cast<double>(camera.width) * camera.height;
  return static_cast<int>(std::ceil(std::sqrt(pixels / kMostVideoPixels)));
}

}  // namespace

void VisitorHost::run(Job job) {
  if (jobs_.size() < kMostJobs) jobs_.push_back(std::move(job));
}

void VisitorHost::refuse() { fail("this is not possible in a browser"); }

Visitor::Visitor(const std::vector<const OpenedScene*>& scenes, glm::ivec2 size, double now)
    : scenes_(scenes), store_(first_viewer(*scenes.front(), size)), began_(now), last_tick_(now) {
  show_scene(0);
}

void Visitor::show_scene(std::size_t scene) {
  if (scene >= scenes_.size()) return;
  scene_ = scene;
  store_.apply(call(action::scene_opened, *scenes_[scene]), host_);
}

void Visitor::apply(const Actions& actions, double now) {
  tick(now);
  for (const Action& action : actions) store_.apply(action, host_);
}

void Visitor::tick(double now) {
  Actions actions;
  input_.tick(actions);
  for (const Action& action : actions) store_.apply(action, host_);
  Turn turn;
  turn.now = now - began_;
  turn.cursor = input_.picture_cursor();
  turn.bare_size = {viewer().camera.width, viewer().camera.height};
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
  if (const auto* resize = std::get_if<message::Resize>(&message.body)) {
    actions.push_back(call(action::resize, resize->size.x, resize->size.y));
  } else if (const auto* key = std::get_if<message::Key>(&message.body)) {
    if (key->key != 0 && (!key->down || may_press(key->key, key->mods)))
      input_.key(key->key, key->down, key->repeat, key->mods, false, actions);
  } else if (const auto* button = std::get_if<message::Button>(&message.body)) {
    move_cursor(button->at);
    input_.button(button->button, button->down, false, moment, actions);
  } else if (const auto* cursor = std::get_if<message::Cursor>(&message.body)) {
    move_cursor(cursor->at);
  } else if (const auto* wheel = std::get_if<message::Wheel>(&message.body)) {
    input_.wheel(wheel->notches, wheel->mods, false, actions);
  } else if (const auto* command = std::get_if<message::Command>(&message.body)) {
    const KeyCommand* const row = find_served_command(command->help);
    if (row != nullptr && !row->on_release) actions.push_back(row->action);
  } else if (const auto* scene = std::get_if<message::ShowScene>(&message.body)) {
    show_scene(scene->scene);
  } else if (const auto* video = std::get_if<message::Video>(&message.body)) {
    quality_.decodes_video(video->decodes);
  } else if (std::holds_alternative<message::Blur>(message.body)) {
    input_.release_all(actions);
  }
  for (const Action& action : actions) store_.apply(action, host_);
}

bool Visitor::waits_for_rest() const {
  return viewer().version != ordered_version_ || !ordered_lossless_;
}

bool Visitor::is_busy() const {
  const Viewer& v = viewer();
  return input_.busy() || v.travel || v.flight.velocity != glm::dvec3(0) ||
         (waits_for_rest() && !rests());
}

// Sooner than in the window: input cancels the picture at rest.
bool Visitor::rests() const { return viewer().now - viewer().last_motion > kRestSeconds; }

std::optional<PictureOrder> Visitor::next_order(double line_rate) {
  const Viewer& v = viewer();
  if (!waits_for_rest()) return {};
  const bool is_new = v.version != ordered_version_;
  if (!is_new && (!rests() || is_busy())) return {};
  PictureOrder order;
  order.scene = scene_;
  order.request = full_frame(v);
  order.request.moving = is_new && v.moving();
  order.input = last_input_;
  order.lossless = !is_new;
  order.encoding = quality_.next(line_rate);
  if (order.request.moving && v.backend == Backend::cpu && v.reduce_when_moving)
    order.request.divisor = resolution_.divisor();
  if (is_new) order.request.divisor = std::max(order.request.divisor, quality_.divisor());
  if (is_new && order.encoding.codec == PictureCodec::vp9)
    order.request.divisor = std::max(order.request.divisor, video_divisor(v.camera));
  ordered_version_ = v.version;
  ordered_lossless_ = order.lossless;
  return order;
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
  resolution_.learn(picture.shown.divisor, cost_of(picture.shown.stats));
  if (!picture.order.lossless) quality_.learn(picture.encoded, picture.shown.divisor);
  apply({call(action::frame_shown, picture.shown)}, now);
}

}  // namespace qs
