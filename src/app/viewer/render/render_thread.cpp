// SPDX-License-Identifier: MIT
#include "app/viewer/render/render_thread.h"

#include <algorithm>

#include "app/session/levels.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/render/resolution.h"
#include "app/viewer/state/samples.h"

namespace qs {
RenderThread::RenderThread(const FrameOptions& options, std::function<void()> wake,
                           GlFrames* frames)
    : wake_(wake),
      frames_(frames),
      reports_(std::move(wake)),
      context_{reports_,
               [this](const FrameRequest& request) {
                 kept_ = {};
                 show(drawn(request));
               },
               [this](RenderedFrame frame) { publish(std::move(frame)); }} {
  context_.give_way = [this] { draw_between(); };
  context_.make_renderer = [this, make = context_.make_renderer, levels = options.levels](
                               Backend backend, const Session& owner) {
    return with_levels(
        make(backend, owner), levels, *owner.pool,
        [this](const LevelFacts& facts) { context_.report(action::levels_made, facts); },
        &awaits_cuts_);
  };
  context_.session.pool = std::make_unique<ThreadPool>(options.threads);
  context_.session.device = options.device == kFirstGpu ? first_gpu() : options.device;
  thread_ = std::jthread([this](const std::stop_token& stop) { loop(stop); });
}

RenderThread::~RenderThread() {
  thread_.request_stop();
  const std::lock_guard lock(mutex_);
  running_.request_stop();
  changed_.notify_all();
}

void RenderThread::request(FrameRequest request) {
  const std::lock_guard lock(mutex_);
  frame_ = std::move(request);
  numbers_.reset();
  if (gives_way()) running_.request_stop();
  changed_.notify_all();
}

void RenderThread::request(NumbersRequest request) {
  const std::lock_guard lock(mutex_);
  numbers_ = std::move(request);
  changed_.notify_all();
}

void RenderThread::cancel_numbers() {
  const std::lock_guard lock(mutex_);
  numbers_.reset();
  if (task_ == Task::numbers) running_.request_stop();
}

void RenderThread::run(Job job) {
  const std::lock_guard lock(mutex_);
  jobs_.push_back(std::move(job));
  if (gives_way()) running_.request_stop();
  changed_.notify_all();
}

void RenderThread::run_behind(Job job) {
  const std::lock_guard lock(mutex_);
  behind_ = std::move(job);
  changed_.notify_all();
}

void RenderThread::stop_job(bool keeps_part) {
  const std::lock_guard lock(mutex_);
  if (task_ != Task::job || running_.stop_requested()) return;
  context_.keeps_part = keeps_part;
  running_.request_stop();
}

std::optional<RenderedFrame> RenderThread::take_frame() {
  const std::lock_guard lock(mutex_);
  return std::exchange(rendered_, std::nullopt);
}

bool RenderThread::busy() {
  const std::lock_guard lock(mutex_);
  return task_ != Task::none || !jobs_.empty() || frame_ || behind_ || numbers_ || rendered_ ||
         !reports_.empty();
}

// Runs one task and shows its error to the user.
void RenderThread::guarded(const std::function<void()>& work) {
  try {
    work();
  } catch (const Cancelled&) {
  } catch (const std::exception& error) {
    reports_.report(action::notify_error, std::string(sentence_of(error)));
  }
}

// Takes the next task that is wanted; null if there is none.
std::function<void()> RenderThread::next_work() {
  const bool ready = context_.session.renderer != nullptr;
  if (!jobs_.empty()) {
    task_ = Task::job;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    return [this, job] { job(context_); };
  }
  if (ready && frame_) {
    const FrameRequest request = *std::exchange(frame_, std::nullopt);
    // If a moving camera cancelled its frames, no frame would be completed.
    task_ = request.moving ? Task::frame : Task::refinement;
    return [this, request] { answer(request); };
  }
  if (ready && behind_) {
    task_ = Task::behind;
    return [this, job = std::exchange(behind_, nullptr)] { job(context_); };
  }
  if (ready && numbers_) {
    task_ = Task::numbers;
    const NumbersRequest request = *std::exchange(numbers_, std::nullopt);
    return [this, request] { measure_modes(context_, request); };
  }
  task_ = Task::none;
  return nullptr;
}

void RenderThread::loop(const std::stop_token& stop) {
  if (frames_ != nullptr) frames_->bind();
  std::unique_lock lock(mutex_);
  std::function<void()> work;
  const auto takes_work = [&] { return (work = next_work()) != nullptr; };
  while (changed_.wait(lock, stop, takes_work) && !stop.stop_requested()) {
    running_ = {};
    context_.stop = running_.get_token();
    context_.keeps_part = true;  // at the end of the program
    awaits_cuts_ = task_ == Task::job;
    lock.unlock();
    guarded(work);
    wake_();
    lock.lock();
  }
  lock.unlock();
  work = nullptr;
  context_.session.renderer.reset();
  context_.beside.reset();
  if (frames_ != nullptr) frames_->unbind();
}

// Draws the frame into a GL texture. Returns empty if that fails or failed a short time ago.
std::optional<RenderedFrame> RenderThread::draw_into_gl(const Camera& camera,
                                                        const FrameRequest& request) {
  if (frames_ == nullptr || context_.session.backend != Backend::cuda) return std::nullopt;
  if (!interop_.tries_next()) return std::nullopt;
  const HeldScale scale = heat_scale(context_, request, camera);
  const Outputs outputs =
      with_counts(request.heatmap ? outputs_for(*request.heatmap) : Outputs(), request);
  Renderer& renderer = *context_.session.renderer;
  GlTexture texture;
  try {
    texture = next_texture_.take(camera.width, camera.height, *frames_, renderer);
    const Frame& frame = renderer.render(camera, request.settings, outputs, texture, context_.stop);
    RenderedFrame rendered{shown_of(request, frame), camera.width, camera.height, {}, {}, texture};
    rendered.shown.interop = true;
    interop_.note_success();
    if (request.heatmap)
      show_map(rendered.shown, make_heatmap(frame, *request.heatmap, camera.width, camera.height),
               scale);
    return rendered;
  } catch (const Error& error) {
    frames_->give_back(texture);
    if (interop_.note_failure())
      reports_.report(action::notify,
                      std::string(error.what()) + "; frames go through host memory for a while");
    return std::nullopt;
  } catch (...) {
    frames_->give_back(texture);
    throw;
  }
}

RenderedFrame RenderThread::drawn(FrameRequest request) {
  const Camera camera = request.camera.reduced(request.divisor);
  request.settings = reduced(request.settings, request.divisor);
  std::optional<RenderedFrame> rendered;
  if (takes_one_frame(request)) rendered = draw_into_gl(camera, request);
  return rendered ? std::move(*rendered) : draw_on_host(context_, request, camera);
}

// Gives a drawn frame to the window.
void RenderThread::show(RenderedFrame frame) {
  const bool gl = frame.texture.name != 0;
  const int width = frame.width, height = frame.height;
  publish(std::move(frame));
  if (gl) next_texture_.prepare(width, height, *frames_, *context_.session.renderer);
}

// Draws the frame of a request, or shows the kept frame of a mode to which the user switched back.
void RenderThread::answer(const FrameRequest& request) {
  if (std::optional<RenderedFrame> kept = kept_.find(request)) {
    kept_.keep(request, *kept);
    publish(std::move(*kept));
    return;
  }
  RenderedFrame frame = drawn(request);
  kept_.keep(request, frame);
  const RenderStats stats = frame.shown.stats;
  show(std::move(frame));
  paired_.follow(context_, request, request.camera.reduced(request.divisor), stats);
}

// Between two parts of a long job: the newest requested frame, so that keys and the mouse work. A
// measurement shows its own frames.
void RenderThread::draw_between() {
  std::optional<FrameRequest> request;
  {
    const std::lock_guard lock(mutex_);
    if (!context_.measuring) request = std::exchange(frame_, std::nullopt);
  }
  if (!request) return;
  const bool awaits = awaits_cuts_.exchange(false);
  guarded([&] { answer(*request); });
  awaits_cuts_ = awaits;
}

// Replaces a frame that the window did not take.
void RenderThread::publish(RenderedFrame frame) {
  {
    const std::lock_guard lock(mutex_);
    if (rendered_ && rendered_->texture.name != 0) frames_->give_back(rendered_->texture);
    rendered_ = std::move(frame);
  }
  wake_();
}

void KeptFrames::keep(const FrameRequest& request, const RenderedFrame& frame) {
  constexpr std::size_t kMost = 2;
  std::erase_if(frames_, [&](const Kept& kept) {
    return kept.picture != request.picture || kept.frame.shown.mode == frame.shown.mode;
  });
  if (request.picture < 0 || request.divisor > 1 || frame.texture.name != 0) return;
  frames_.push_back({request.picture, frame});
  if (frames_.size() > kMost) frames_.pop_front();
}

std::optional<RenderedFrame> KeptFrames::find(const FrameRequest& request) const {
  if (request.picture < 0 || request.divisor > 1 || frames_.empty() ||
      frames_.back().frame.shown.mode == request.settings.mode)
    return std::nullopt;
  for (const Kept& kept : frames_) {
    if (kept.picture != request.picture || kept.frame.shown.mode != request.settings.mode) continue;
    if (request.counted && (kept.frame.shown.mode_pairs.empty() ||
                            kept.frame.shown.counted_size != size_of(request.counted->camera)))
      return std::nullopt;
    RenderedFrame frame = kept.frame;
    frame.shown.version = request.version;
    return frame;
  }
  return std::nullopt;
}

}  // namespace qs
