// SPDX-License-Identifier: MIT
#include "app/serve/served_training.h"

#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "app/viewer/state/training_actions.h"
#include "base/error.h"

namespace qs {

constexpr std::chrono::milliseconds kLookTime{100};  ///< between two looks for the first model
constexpr double kFarewellSeconds = 0.5;             ///< for visitors to hear of the end

void ServedTraining::apply(const Actions& actions) {
  for (const Action& action : actions) store_.apply(action, host_);
}

void ServedTraining::apply_reports() {
  Actions reports;
  thread_.take_reports(reports);
  apply(reports);
}

bool ServedTraining::has_run_ended() const {
  const auto& training = store_.viewer().training;
  return training && training->phase == TrainingPhase::ended;
}

void ServedTraining::outlive(const std::function<void()>& page,
                             const std::function<void(const std::string& sentence)>& tell,
                             const std::function<void()>& turn) {
  try {
    return page();
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception& error) {
    tell(fmt::format("the page has ended, and the training goes on without it: {}", error.what()));
  }
  thread_.command(TrainingCommand::resume);  // the page had the button
  while (!has_run_ended()) {
    turn();
    thread_.take_model();  // the run waits until its first model is taken
    apply_reports();
    std::this_thread::sleep_for(kLookTime);
  }
}

std::unique_ptr<ServedScene> ServedTraining::open(const PageFacts& page,
                                                  const std::function<bool()>& stops) {
  std::optional<TrainedModel> model;
  while (!(model = thread_.take_model())) {
    apply_reports();
    if (stops() || has_run_ended()) return nullptr;
    std::this_thread::sleep_for(kLookTime);
  }
  auto served = std::make_unique<ServedScene>();
  Session& session = served->context.session;
  session.pool = std::make_unique<ThreadPool>(page.threads);
  session.device = page.device == kFirstGpu ? first_gpu() : page.device;
  open_trained(*model, page.backend, page.settings)(served->context);
  Actions reports;
  thread_.take_reports(reports);
  served->reports.take(reports);
  apply(reports);
  const Viewer& v = store_.viewer();
  served->opened = {*v.scene, v.settings, v.backend};
  return served;
}

Actions ServedTraining::follow(Pictures& pictures, bool has_visitors, double now) {
  has_visitors_ = has_visitors;
  if (visitor_ == 0) visitor_ = pictures.new_visitor();
  Turn turn;
  turn.now = now;
  Actions actions;
  thread_.take_reports(actions);
  apply({call(action::tick, turn, 0.0)});
  apply(actions);
  const Viewer& v = store_.viewer();
  if (std::optional<TrainedModel> model = thread_.take_model()) {
    uploads_ = true;
    pictures.run(visitor_, 0, show_model(*model));
  } else if (has_visitors && is_training(v) && may_draw(v) && !uploads_) {
    thread_.want_model();
  }
  if (has_run_ended() && ended_at_ < 0) ended_at_ = now;
  return actions;
}

void ServedTraining::job_reported(const Actions& actions) {
  if (actions.empty()) uploads_ = false;
  apply(actions);
}

Action ServedTraining::greeting() const {
  Training training = store_.viewer().training.value_or(Training());
  training.views = nullptr;  // the page does not compare photographs
  training.budget = {};      // of the visitor's own pictures
  const std::uint64_t gaussians = store_.viewer().scene->gaussians;
  return [training, gaussians](Viewer& v, Host&) {
    v.training = training;
    v.panels.training = true;
    v.scene->gaussians = gaussians;
  };
}

bool ServedTraining::has_ended() const {
  const double farewell = has_visitors_ ? kFarewellSeconds : 0;
  return ended_at_ >= 0 && store_.viewer().now >= ended_at_ + farewell;
}

}  // namespace qs
