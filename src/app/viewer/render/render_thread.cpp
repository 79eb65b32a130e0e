// SPDX-License-Identifier: MIT
#include "app/viewer/render/render_thread.h"

#include <algorithm>

#include "app/viewer/render/host_frames.h"

namespace qs {
namespace {

// Quick enough not to be noticed, long enough for a steady median; a slow CPU gets one frame.
ViewPlan numbers_plan(Backend backend) {
  return backend == Backend::cpu ? ViewPlan{1, 0, 1} : ViewPlan{40, 8, 1};
}

}  // namespace

RenderThread::RenderThread(const FrameOptions& options, std::function<void()> wake,
                           GlFrames* frames)
    : wake_(std::move(wake)), frames_(frames), gl_works_(frames != nullptr) {
  context_.session.pool = std::make_unique<ThreadPool>(options.threads);
  context_.session.device = options.device;
  context_.report = [this](Action action) { report(std::move(action)); };
  context_.show = [this](const FrameOrder& order) { draw(order); };
  thread_ = std::jthread([this](const std::stop_token& stop) { loop(stop); });
}

RenderThread::~RenderThread() {
  thread_.request_stop();
  {
    const std::lock_guard lock(mutex_);
    running_.request_stop();
  }
  changed_.notify_all();
}

void RenderThread::order(FrameOrder order) {
  {
    const std::lock_guard lock(mutex_);
    frame_ = std::move(order);
    numbers_.reset();
    if (task_ == Task::numbers || task_ == Task::refinement) running_.request_stop();
  }
  changed_.notify_all();
}

void RenderThread::order(NumbersOrder order) {
  {
    const std::lock_guard lock(mutex_);
    numbers_ = std::move(order);
  }
  changed_.notify_all();
}

void RenderThread::drop_numbers() {
  const std::lock_guard lock(mutex_);
  numbers_.reset();
  if (task_ == Task::numbers) running_.request_stop();
}

void RenderThread::run(Job job) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
    if (task_ == Task::numbers || task_ == Task::refinement) running_.request_stop();
  }
  changed_.notify_all();
}

void RenderThread::stop_job() {
  const std::lock_guard lock(mutex_);
  if (task_ == Task::job) running_.request_stop();
}

void RenderThread::take_reports(Actions& actions) {
  const std::lock_guard lock(mutex_);
  for (Action& report : reports_) actions.push_back(std::move(report));
  reports_.clear();
}

std::optional<FrameReply> RenderThread::take_frame() {
  const std::lock_guard lock(mutex_);
  return std::exchange(reply_, std::nullopt);
}

bool RenderThread::busy() {
  const std::lock_guard lock(mutex_);
  return task_ != Task::none || !jobs_.empty() || frame_ || numbers_ || reply_ || !reports_.empty();
}

void RenderThread::report(Action action) {
  {
    const std::lock_guard lock(mutex_);
    reports_.push_back(std::move(action));
  }
  wake_();
}

// Runs one piece of work; what goes wrong becomes a sentence in the window.
template <class Work>
void RenderThread::guarded(Work&& work) {
  try {
    work();
  } catch (const Cancelled&) {
  } catch (const std::bad_alloc&) {
    report(action::Say{"not enough memory", true});
  } catch (const std::exception& error) {
    report(action::Say{error.what(), true});
  }
}

void RenderThread::loop(const std::stop_token& stop) {
  if (frames_ != nullptr) frames_->bind();
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    running_ = {};
    context_.stop = running_.get_token();
    const bool ready = context_.session.renderer != nullptr;
    if (!jobs_.empty()) {
      const Job job = std::move(jobs_.front());
      jobs_.pop_front();
      task_ = Task::job;
      lock.unlock();
      guarded([&] { job(context_); });
    } else if (ready && frame_) {
      const FrameOrder order = *std::exchange(frame_, std::nullopt);
      // Frames of two variants are slow: while the camera moves each of them is shown.
      task_ = order.divisor > 1 || order.other ? Task::frame : Task::refinement;
      lock.unlock();
      guarded([&] { draw(order); });
    } else if (ready && numbers_) {
      const NumbersOrder order = *std::exchange(numbers_, std::nullopt);
      task_ = Task::numbers;
      lock.unlock();
      guarded([&] { measure(order); });
    } else {
      task_ = Task::none;
      changed_.wait(lock, stop, [&] {
        const bool drawable = context_.session.renderer != nullptr;
        return !jobs_.empty() || (drawable && (frame_ || numbers_));
      });
      continue;
    }
    wake_();
    lock.lock();
  }
  lock.unlock();
  context_.session.renderer.reset();
  if (frames_ != nullptr) frames_->unbind();
}

// The frame in a GL texture, or nothing where that is not possible: never tried again then.
std::optional<FrameReply> RenderThread::draw_into_gl(const Camera& camera,
                                                     const FrameOrder& order) {
  if (!gl_works_ || context_.session.backend != Backend::cuda) return std::nullopt;
  GlTexture texture = std::exchange(next_texture_, {});
  if (texture.name != 0 && (camera.width != next_width_ || camera.height != next_height_)) {
    context_.session.renderer->prepare_target(HostImage{});
    frames_->give_back(std::exchange(texture, {}));
  }
  if (texture.name == 0) texture = frames_->take(camera.width, camera.height);
  const Outputs outputs = order.heatmap ? outputs_for(*order.heatmap) : Outputs();
  try {
    const Frame& frame =
        context_.session.renderer->render(camera, order.settings, outputs, texture, context_.stop);
    FrameReply reply{shown_of(order, frame.stats), camera.width, camera.height, {}, {}, texture};
    reply.shown.interop = true;
    if (order.heatmap)
      reply.shown.heatmap = make_heatmap(frame, *order.heatmap, camera.width, camera.height);
    return reply;
  } catch (const Error& error) {
    frames_->give_back(texture);
    gl_works_ = false;
    report(action::Say{std::string(error.what()) + "; frames pass the host instead"});
    return std::nullopt;
  } catch (...) {
    frames_->give_back(texture);
    throw;
  }
}

void RenderThread::draw(const FrameOrder& order) {
  Camera camera = order.camera;
  if (order.divisor > 1) {
    camera = camera.resized(std::max(1, camera.width / order.divisor),
                            std::max(1, camera.height / order.divisor));
  }
  std::optional<FrameReply> reply;
  if (takes_one_frame(order)) reply = draw_into_gl(camera, order);
  if (!reply) reply = draw_on_host(context_, order, camera);
  const bool gl = reply->texture.name != 0;
  {
    const std::lock_guard lock(mutex_);
    if (reply_ && reply_->texture.name != 0) frames_->give_back(reply_->texture);
    reply_ = std::move(reply);
  }
  wake_();
  if (gl) expect(camera.width, camera.height);
}

// The next frame's texture is made ready while the window shows this one.
void RenderThread::expect(int width, int height) {
  next_texture_ = frames_->take(width, height);
  next_width_ = width;
  next_height_ = height;
  context_.session.renderer->prepare_target(next_texture_);
}

void RenderThread::measure(const NumbersOrder& order) {
  report(action::MeasuringChanged{true});
  const ReportAtEnd end(context_, action::MeasuringChanged{false});
  Session& session = context_.session;
  const WithSettings settings(session, order.settings);
  std::vector<BenchRow> rows;
  try {
    for (const Pipeline pipeline : pipelines_of(session.backend)) {
      session.settings.pipeline = pipeline;
      const std::vector<BenchRow> measured = measure_view(
          session, all_modes(), order.camera, numbers_plan(session.backend), {{}, context_.stop});
      rows.insert(rows.end(), measured.begin(), measured.end());
    }
  } catch (const Cancelled&) {
    throw;
  } catch (...) {
    report(action::NumbersMeasured{{order.version, {}}});  // there are none: not to be tried again
    throw;
  }
  report(action::NumbersMeasured{{order.version, std::move(rows)}});
}

}  // namespace qs
