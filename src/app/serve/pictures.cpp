// SPDX-License-Identifier: MIT
#include "app/serve/pictures.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <new>
#include <utility>

#include "app/picture/heatmap.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/render/resolution.h"
#include "io/picture/encode.h"
#include "raster/base/error.h"

namespace qs {
namespace {

Image image_of(const std::vector<std::uint8_t>& rgba, int width, int height) {
  Image image(width, height, 3);
  for (std::size_t i = 0; i < rgba.size() / 4; ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      image.values[3 * i + c] = static_cast<float>(rgba[4 * i + c]) / 255;
  }
  return image;
}

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// The sentence of an exception; nothing for Cancelled.
std::string sentence_of(const std::exception_ptr& exception) {
  try {
    std::rethrow_exception(exception);
  } catch (const Cancelled&) {
    return {};
  } catch (const std::bad_alloc&) {
    return "not enough memory";
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace

std::vector<std::uint8_t> painted(const FrameRequest& request, RenderedFrame frame) {
  const ShownFrame& shown = frame.shown;
  if (!shown.heatmap && !shown.values) return std::move(frame.rgba);
  Image image = image_of(frame.rgba, frame.width, frame.height);
  const char* const mode = mode_name(shown.mode);
  if (shown.heatmap) {
    image = draw_over(image, *shown.heatmap, shown.map_scale, request.heat_style);
    draw_legend_over(image,
                     make_legend(*shown.heatmap, shown.map_scale, mode, request.heat_style.colors));
  } else {
    draw_legend_over(image, make_legend(*shown.values, mode));
  }
  return to_rgba(image);
}

Pictures::Pictures(ServedScenes& scenes, Receiver receiver)
    : scenes_(scenes), receiver_(std::move(receiver)) {
  const unsigned encoders = std::max(2u, std::thread::hardware_concurrency()) - 1;
  for (unsigned i = 0; i < encoders; ++i)
    encoders_.emplace_back([this](const std::stop_token& stop) { encode(stop); });
  renderer_ = std::jthread([this](const std::stop_token& stop) { render(stop); });
}

Pictures::~Pictures() {
  all_.request_stop();
  renderer_.request_stop();
  for (std::jthread& encoder : encoders_) encoder.request_stop();
  {
    const std::lock_guard lock(mutex_);
    for (auto& [visitor, work] : work_) work.stop.request_stop();
  }
  changed_.notify_all();
}

void Pictures::order(int visitor, PictureOrder order) {
  {
    const std::lock_guard lock(mutex_);
    Work& work = work_[visitor];
    work.used_ms = std::max(work.used_ms, served_ms_);  // time without orders is no claim
    work.order = std::move(order);
  }
  changed_.notify_all();
}

void Pictures::run(int visitor, std::size_t scene, Job job) {
  {
    const std::lock_guard lock(mutex_);
    Work& work = work_[visitor];
    work.used_ms = std::max(work.used_ms, served_ms_);
    work.jobs.emplace_back(scene, std::move(job));
  }
  changed_.notify_all();
}

void Pictures::cancel_lossless(int visitor) {
  const std::lock_guard lock(mutex_);
  const auto found = work_.find(visitor);
  if (found != work_.end() && found->second.lossless) found->second.stop.request_stop();
}

void Pictures::forget(int visitor) {
  const std::lock_guard lock(mutex_);
  const auto found = work_.find(visitor);
  if (found == work_.end()) return;
  found->second.stop.request_stop();
  work_.erase(found);
}

int Pictures::next_visitor() const {
  int next = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [visitor, work] : work_) {
    if (!work.order && work.jobs.empty()) continue;
    if (work.used_ms < least) least = work.used_ms, next = visitor;
  }
  return next;
}

void Pictures::render(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return next_visitor() >= 0; })) {
    const int visitor = next_visitor();
    Work& work = work_[visitor];
    served_ms_ = work.used_ms;
    const auto began = std::chrono::steady_clock::now();
    if (!work.jobs.empty() && (work.drew_last || !work.order)) {
      const auto [scene, job] = std::move(work.jobs.front());
      work.jobs.pop_front();
      work.drew_last = false;
      lock.unlock();
      run_job(visitor, scene, job);
    } else {
      PictureOrder next = std::move(*work.order);
      work.order.reset();
      work.drew_last = true;
      work.stop = std::stop_source();
      work.lossless = next.lossless;
      const std::stop_token token = work.stop.get_token();
      const std::optional<HeldScale> scale = work.heat_scale;
      lock.unlock();
      draw(visitor, std::move(next), token, scale);
    }
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - began;
    lock.lock();
    const auto found = work_.find(visitor);
    if (found != work_.end()) found->second.used_ms += spent.count();
  }
}

void Pictures::draw(int visitor, PictureOrder order, std::stop_token stop,
                    std::optional<HeldScale> heat_scale) {
  Drawn drawn;
  drawn.visitor = visitor;
  drawn.stop = stop;
  drawn.picture.order = std::move(order);
  const FrameRequest& request = drawn.picture.order.request;
  RenderContext& context = scenes_[drawn.picture.order.scene]->context;
  try {
    context.stop = stop;
    context.heat_scale = std::move(heat_scale);
    FrameRequest scaled = request;
    Camera camera = request.camera;
    if (request.divisor > 1) {
      camera = reduced(camera, request.divisor);
      scaled.settings = reduced(scaled.settings, request.divisor);
    }
    RenderedFrame frame = draw_on_host(context, scaled, camera);
    drawn.picture.shown = frame.shown;
    drawn.picture.width = frame.width;
    drawn.picture.height = frame.height;
    drawn.rgba = painted(scaled, std::move(frame));
    drawn.now = steady_seconds();
  } catch (...) {
    drawn.picture.error = sentence_of(std::current_exception());
    drawn.rgba.clear();
  }
  {
    const std::lock_guard lock(mutex_);
    const auto found = work_.find(visitor);
    if (found != work_.end()) found->second.heat_scale = context.heat_scale;
    drawn_.push_back(std::move(drawn));
  }
  changed_.notify_all();
  receiver_.drawn(visitor);
}

void Pictures::run_job(int visitor, std::size_t scene, const Job& job) {
  ServedScene& served = *scenes_[scene];
  Actions actions;
  try {
    served.context.stop = all_.get_token();
    job(served.context);
  } catch (...) {
    const std::string sentence = sentence_of(std::current_exception());
    if (!sentence.empty()) actions.push_back(call(action::notify_error, sentence));
  }
  served.reports.take(actions);
  receiver_.report(visitor, std::move(actions));
}

// Moving pictures first: a picture at rest takes several times as long.
std::deque<Pictures::Drawn>::iterator Pictures::next_drawn() {
  const auto is_free = [&](const Drawn& drawn) {
    const auto found = work_.find(drawn.visitor);
    return found == work_.end() || !found->second.encodes;
  };
  const auto moving = std::find_if(drawn_.begin(), drawn_.end(), [&](const Drawn& drawn) {
    return is_free(drawn) && !drawn.picture.order.lossless;
  });
  return moving != drawn_.end() ? moving : std::find_if(drawn_.begin(), drawn_.end(), is_free);
}

void Pictures::encode(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return next_drawn() != drawn_.end(); })) {
    const auto next = next_drawn();
    Drawn drawn = std::move(*next);
    drawn_.erase(next);
    const auto before = work_.find(drawn.visitor);
    std::shared_ptr<PictureEncoder> encoder;  // none if the visitor has left
    if (before != work_.end()) {
      encoder = before->second.encoder;
      before->second.encodes = true;
    }
    lock.unlock();
    if (encoder) encode(*encoder, drawn);
    receiver_.ready(drawn.visitor, std::move(drawn.picture));
    lock.lock();
    const auto after = work_.find(drawn.visitor);
    if (after != work_.end()) after->second.encodes = false;
    changed_.notify_all();
  }
}

void Pictures::encode(PictureEncoder& encoder, Drawn& drawn) {
  Picture& picture = drawn.picture;
  if (drawn.rgba.empty() || drawn.stop.stop_requested()) return;
  try {
    Encoding encoding = picture.order.encoding;
    if (picture.order.lossless) encoding.codec = PictureCodec::webp;
    picture.encoded = encoder.encode({drawn.rgba, picture.width, picture.height}, encoding,
                                     drawn.now, drawn.stop);
  } catch (...) {
    picture.error = sentence_of(std::current_exception());
  }
}

}  // namespace qs
