// SPDX-License-Identifier: MIT
#include "app/viewer/state/training_actions.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/base/text.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/zoom_text.h"

namespace qs {

void DrawingBudget::spent(double now, double seconds, double most) {
  free_at_ = std::max(free_at_, now - seconds) + seconds / most;
  pieces_.push_back({now, seconds});
  while (pieces_.front().end < now - kWindow) pieces_.pop_front();
}

double DrawingBudget::share(double now) const {
  double sum = 0;
  for (const Piece& piece : pieces_)
    sum += std::max(0.0, piece.end - std::max(piece.end - piece.seconds, now - kWindow));
  return std::min(1.0, sum / kWindow);
}

bool is_training(const Viewer& viewer) {
  return viewer.training && viewer.training->phase == TrainingPhase::running;
}

bool may_draw(const Viewer& viewer) {
  return !is_training(viewer) || viewer.training->budget.allows(viewer.now);
}

namespace {

// At the speed of the last iterations; unset before the first and after the last.
std::optional<double> seconds_left(const Training& training) {
  const TrainingProgress& progress = training.progress;
  if (training.phase == TrainingPhase::ended || progress.iterations_per_second <= 0)
    return std::nullopt;
  return (progress.iterations - progress.iteration) / progress.iterations_per_second;
}

}  // namespace

std::string loss_plot_text(const Training& training) {
  const float largest = *std::max_element(training.losses.begin(), training.losses.end());
  return fmt::format("loss of the last {} reports, 0 to {:.3f}", training.losses.size(), largest);
}

std::vector<Fact> training_facts(const Viewer& viewer) {
  if (!viewer.training) return {};
  const Training& training = *viewer.training;
  const TrainingProgress& progress = training.progress;
  const auto count = [](int number) { return grouped(static_cast<std::uint64_t>(number)); };
  std::vector<Fact> facts = {
      {"state", training.phase == TrainingPhase::running  ? "running"
                : training.phase == TrainingPhase::paused ? "paused"
                                                          : training.outcome},
      {"iteration", fmt::format("{} of {}", count(progress.iteration), count(progress.iterations))},
      {"loss", progress.iteration > 0 ? fmt::format("{:.4f}", progress.loss) : "-"}};
  facts.push_back(
      {"test PSNR",
       progress.test_psnr
           ? fmt::format("{} dB, SSIM {:.4f} at iteration {}", decibels(*progress.test_psnr),
                         progress.test_ssim.value_or(0), count(progress.evaluated))
           : "-"});
  facts.push_back({"Gaussians", grouped(progress.gaussians)});
  facts.push_back({"speed", progress.iterations_per_second > 0
                                ? fmt::format("{:.1f} iterations/s", progress.iterations_per_second)
                                : "-"});
  if (const std::optional<double> left = seconds_left(training))
    facts.push_back({"time left", about_text(*left)});
  facts.push_back(
      {"drawing", fmt::format("{:.0f} % of the time", 100 * training.budget.share(viewer.now))});
  facts.push_back({"in the window", fmt::format("iteration {}", count(training.shown))});
  facts.push_back({"model", training.folder.string()});
  return facts;
}

namespace action {

void start_training(Viewer& v, Host& host, const TrainingRequest& request) {
  if (v.training && v.training->phase != TrainingPhase::ended)
    return notify_error(v, "a model is being trained: stop that run first");
  v.training = Training();
  host.start_training(request);
}

void command_training(Viewer& v, Host& host, TrainingCommand command) {
  if (!v.training || v.training->phase == TrainingPhase::ended) return;
  const bool paused = v.training->phase == TrainingPhase::paused;
  if (command == TrainingCommand::pause && paused) return;
  if (command == TrainingCommand::resume && !paused) return;
  host.train(command);
}

void toggle_training(Viewer& v, Host& host) {
  const bool paused = v.training && v.training->phase == TrainingPhase::paused;
  command_training(v, host, paused ? TrainingCommand::resume : TrainingCommand::pause);
}

void training_began(Viewer& v, const std::filesystem::path& folder) {
  if (!v.training || v.training->phase == TrainingPhase::ended) v.training = Training();
  v.training->folder = folder;
  v.panels.training = true;
}

void training_progressed(Viewer& v, const TrainingProgress& progress) {
  if (!v.training) return;
  Training& training = *v.training;
  if (progress.iteration > training.progress.iteration) {
    training.losses.push_back(static_cast<float>(progress.loss));
    if (training.losses.size() > Training::kMostLosses) training.losses.pop_front();
  }
  training.progress = progress;
}

void training_paused(Viewer& v, bool paused) {
  if (!v.training || v.training->phase == TrainingPhase::ended) return;
  v.training->phase = paused ? TrainingPhase::paused : TrainingPhase::running;
}

void training_ended(Viewer& v, const std::string& outcome, bool is_error) {
  if (!v.training) return;
  v.training->phase = TrainingPhase::ended;
  v.training->outcome = outcome;
  if (is_error) {
    notify_error(v, outcome);
    end_progress(v);
  } else {
    notify(v, outcome);
  }
}

void model_shown(Viewer& v, int iteration, std::uint64_t gaussians, double seconds) {
  if (!v.training || !v.scene) return;
  v.training->shown = iteration;
  v.training->budget.spent(v.now, seconds, DrawingBudget::kResting);
  v.scene->gaussians = gaussians;
  v.inspected.reset();
  view_changed(v);
}

}  // namespace action
}  // namespace qs
