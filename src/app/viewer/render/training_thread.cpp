// SPDX-License-Identifier: MIT
#include "app/viewer/render/training_thread.h"

#include <new>
#include <utility>

#include "app/viewer/render/scene_reading.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/actions.h"
#include "base/seconds.h"

namespace qs {
namespace {

constexpr double kReportSeconds = 0.25;  // between two reports of progress
constexpr double kSpeedSeconds = 1;      // over which the speed is measured

}  // namespace

TrainingThread::TrainingThread(std::function<void()> wake, Work work)
    : reports_(wake), wake_(std::move(wake)) {
  thread_ = std::thread([this, work = std::move(work)] { run(work); });
}

TrainingThread::~TrainingThread() {
  command(TrainingCommand::stop);
  thread_.join();
}

void TrainingThread::run(const Work& work) {
  std::string outcome;
  bool failed = true;
  try {
    outcome = work(*this);
    failed = false;
  } catch (const Cancelled&) {
    outcome = "stopped before it began";
    failed = false;
    reports_.report(action::end_progress);
  } catch (const std::exception& error) {
    outcome = sentence_of(error);
  }
  {
    const std::lock_guard lock(mutex_);
    ended_ = began_ = true;
  }
  reports_.report(action::training_ended, outcome, failed);
}

Progress TrainingThread::reading(const std::filesystem::path& data) {
  Progress progress;
  progress.report = [this, data](float fraction) {
    {
      const std::lock_guard lock(mutex_);
      if (stopping_) throw Cancelled{};
    }
    reports_.report(action::show_progress, Loading{data, "reading photographs", fraction});
  };
  return progress;
}

void TrainingThread::began(const std::filesystem::path& folder, const std::filesystem::path& data,
                           const std::shared_ptr<const TestViews>& views) {
  folder_ = folder;
  data_ = data;
  {
    const std::lock_guard lock(mutex_);
    began_ = true;
  }
  reports_.report(action::training_began, folder, views);
  reports_.report(action::show_progress, Loading{folder, "preparing", 0});
}

TrainingCommand TrainingThread::after_iteration(TrainingProgress progress,
                                                const std::function<GaussianCloud()>& model) {
  if (handed_over_ < 0) hand_over(progress, model);
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return shown_first_ || stopping_; });
  const bool last = progress.iteration >= progress.iterations;
  bool waited = false, steps = false;
  if (paused_ && !stopping_ && !last) {
    lock.unlock();
    hand_over(progress, model);
    reports_.report(action::training_progressed, progress);
    reports_.report(action::training_paused, true);
    shows_pause_ = true;
    lock.lock();
    obeying_ = false;
    changed_.wait(lock, [&] { return !paused_ || steps_ > 0 || stopping_ || saving_; });
    waited = true;
    steps = paused_ && !saving_ && !stopping_;
    if (steps) --steps_;
  }
  // The run may have been resumed while an iteration or the saving ran.
  if (shows_pause_ && !paused_) {
    reports_.report(action::training_paused, false);
    shows_pause_ = false;
  }
  const bool stops = stopping_, saves = std::exchange(saving_, false);
  const bool shows = wanted_ || stops || last;
  if (shows) wanted_ = false;
  obeying_ = steps || saves || stops;
  lock.unlock();
  measure_speed(progress, waited);
  if (shows) hand_over(progress, model);
  if (shows || seconds_since(reported_) >= kReportSeconds) {
    reported_ = Clock::now();
    reports_.report(action::training_progressed, progress);
  }
  return stops ? TrainingCommand::stop : saves ? TrainingCommand::save : TrainingCommand::go_on;
}

void TrainingThread::measure_speed(TrainingProgress& progress, bool was_paused) {
  const double seconds = seconds_since(measured_);
  const bool begins = measured_ == Clock::time_point() || was_paused;
  if (begins || seconds >= kSpeedSeconds) {
    if (!begins) speed_ = (progress.iteration - measured_iteration_) / seconds;
    measured_ = Clock::now();
    measured_iteration_ = progress.iteration;
  }
  progress.iterations_per_second = speed_;
}

void TrainingThread::hand_over(const TrainingProgress& progress,
                               const std::function<GaussianCloud()>& model) {
  if (progress.iteration == handed_over_) return;
  handed_over_ = progress.iteration;
  const Clock::time_point begin = Clock::now();
  const auto scene = std::make_shared<Scene>();
  scene->path = folder_;
  scene->format = "in training";
  scene->cloud = model();
  {
    const std::lock_guard lock(mutex_);
    model_ = {scene, progress.iteration, seconds_since(begin), data_};
  }
  wake_();
}

void TrainingThread::command(TrainingCommand command) {
  using enum TrainingCommand;
  const std::lock_guard lock(mutex_);
  obeying_ = true;
  if (command == step && paused_) ++steps_;
  if (command == pause || command == step) paused_ = true;
  if (command == resume) {
    paused_ = false;
    steps_ = 0;
  }
  saving_ |= command == save;
  stopping_ |= command == stop;
  changed_.notify_all();
}

void TrainingThread::want_model() {
  const std::lock_guard lock(mutex_);
  wanted_ = true;
}

std::optional<TrainedModel> TrainingThread::take_model() {
  const std::lock_guard lock(mutex_);
  if (model_ && !shown_first_) {
    shown_first_ = true;
    changed_.notify_all();
  }
  return std::exchange(model_, std::nullopt);
}

bool TrainingThread::reads() {
  const std::lock_guard lock(mutex_);
  return !began_;
}

bool TrainingThread::busy() {
  const std::lock_guard lock(mutex_);
  return (obeying_ && !ended_) || model_ || !reports_.empty();
}

Job open_trained(const TrainedModel& model, Backend backend, const RenderSettings& settings) {
  return [=](RenderContext& context) {
    const auto end = hide_progress_at_end(context);
    const std::filesystem::path cameras = model.scene->path / "cameras.json";
    UploadOrder order{
        model.scene, view_facts(*model.scene, cameras, *context.session.pool), {}, backend};
    order.facts.photographs = find_photographs(model.data / "cameras.json", order.facts.cameras);
    order.settings = settings_for(order.facts, settings, false);
    context.report(action::scene_opened,
                   show_scene(context, order, upload_progress(context, *model.scene)));
    context.trained_iteration = model.iteration;
    context.report(action::model_shown, model.iteration, std::uint64_t{model.scene->cloud.size()},
                   model.seconds);
  };
}

Job show_model(const TrainedModel& model) {
  return [model](RenderContext& context) {
    Session& session = context.session;
    if (!session.scene || session.scene->path != model.scene->path) return;
    const auto begin = std::chrono::steady_clock::now();
    session.second.reset();
    context.reference.reset();
    session.gone = nullptr;
    session.renderer->upload(cloud_of(model.scene), {});
    session.scene = model.scene;
    context.trained_iteration = model.iteration;
    context.report(action::model_shown, model.iteration, std::uint64_t{model.scene->cloud.size()},
                   model.seconds + seconds_since(begin));
  };
}

}  // namespace qs
