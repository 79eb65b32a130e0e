// SPDX-License-Identifier: MIT
#include "app/viewer/state/training_actions.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include <fmt/format.h>

#include "app/viewer/state/actions.h"
#include "app/viewer/state/zoom_actions.h"
#include "base/fail.h"
#include "base/text.h"
#include "learn/run/settings.h"
#include "learn/run/strategy.h"

namespace qs {
namespace {

// At the speed of the last iterations; unset before the first and after the last.
std::optional<double> seconds_left(const Training& training) {
  const TrainingProgress& progress = training.progress;
  if (training.phase == TrainingPhase::ended || progress.iterations_per_second <= 0)
    return std::nullopt;
  return (progress.iterations - progress.iteration) / progress.iterations_per_second;
}

constexpr float kAssumedRadius = 4;  ///< of a scene about which nothing is known, world units

// Trainers place the cameras of a capture around the origin, with y down.
ViewedScene remote_scene(const std::string& address, const std::vector<Camera>& cameras) {
  ViewedScene scene;
  scene.path = address;
  scene.name = address;
  scene.format = "a training in another program";
  scene.core = {glm::vec3(-kAssumedRadius), glm::vec3(kAssumedRadius)};
  scene.smallest_radius = 1;
  scene.framing.eye = {0, -0.25 * kAssumedRadius, -kAssumedRadius};
  scene.cameras = cameras;
  use_cameras(scene);
  return scene;
}

bool is_count(double number) { return number >= 0 && number < 1e15; }

// The last loss stays, because it is the newest.
void drop_every_second(std::vector<LossPoint>& losses) {
  const std::size_t first = (losses.size() + 1) % 2;
  std::size_t kept = 0;
  for (std::size_t i = first; i < losses.size(); i += 2) losses[kept++] = losses[i];
  losses.resize(kept);
}

// Null if the panel does not show this view of this run.
TestView* shown_test_view(Viewer& v, const std::shared_ptr<const TestViews>& views,
                          std::size_t view) {
  if (!v.training || v.training->views != views || v.training->test_view.view != view)
    return nullptr;
  return &v.training->test_view;
}

}  // namespace

std::string usual_model(const std::string& data) {
  const std::filesystem::path path = std::filesystem::path(data).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).string() + "_model";
}

std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream text(line);
  while (!(text >> std::ws).eof()) {
    std::string word;
    text >> std::quoted(word);  // a quote without end lasts to the end of the line
    words.push_back(std::move(word));
  }
  return words;
}

TrainingRequest request_of(const TrainForm& form) {
  TrainingRequest request{form.data, form.model.empty() ? usual_model(form.data) : form.model, {}};
  std::vector<std::string>& options = request.options;
  const auto add = [&](const char* name, const char* value) {
    if (value != nullptr) options.insert(options.end(), {name, value});
  };
  if (form.iterations > 0)
    options.insert(options.end(), {"--iterations", fmt::format("{}", form.iterations)});
  add("--resolution-scale", kTrainSizes[form.size].value);
  const train::Strategy& strategy = train::strategies()[form.strategy];
  add("--strategy", &strategy == &train::default_strategy() ? nullptr : strategy.name);
  for (std::string& word : words_of(form.more)) options.push_back(std::move(word));
  return request;
}

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

std::string test_view_title(const Training& training) {
  const TestViews& views = *training.views;
  const std::size_t view = training.test_view.view;
  return fmt::format("{} view {} ({} of {})", views.held_out ? "test" : "training",
                     views.cameras[view].name, view + 1, views.cameras.size());
}

std::string test_view_text(const Viewer& viewer) {
  const TestView& shown = viewer.training->test_view;
  if (!shown.problem.empty()) return shown.problem;
  const TestComparison& comparison = shown.comparison;
  if (comparison.picture)
    return fmt::format("PSNR {} dB, SSIM {:.4f} at iteration {}", decibels(comparison.psnr),
                       comparison.ssim, grouped(static_cast<std::uint64_t>(comparison.iteration)));
  if (!shown.photograph) return "reading the photograph";
  if (!window_shows_model(viewer)) return "the window shows another scene than the model";
  return shows_part_of_model(viewer) ? "undo the crop to compare the model" : "drawing";
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
  if (!progress.overfitting.empty()) facts.push_back({"test views", progress.overfitting});
  if (!progress.guard.empty()) facts.push_back({"guard", progress.guard});
  facts.push_back({"Gaussians", grouped(progress.gaussians)});
  facts.push_back({"speed", progress.iterations_per_second > 0
                                ? fmt::format("{:.1f} iterations/s", progress.iterations_per_second)
                                : "-"});
  if (const std::optional<double> left = seconds_left(training))
    facts.push_back({"time left", about_text(*left)});
  facts.push_back(
      {"drawing", fmt::format("{:.0f} % of the time", 100 * training.budget.share(viewer.now))});
  facts.push_back({viewer.is_remote ? "in the picture" : "in the window",
                   fmt::format("iteration {}", count(training.shown))});
  if (!viewer.is_remote) facts.push_back({"model", training.folder.string()});
  return facts;
}

bool window_shows_model(const Viewer& viewer) {
  return viewer.training && viewer.scene && viewer.scene->path == viewer.training->folder;
}

bool shows_part_of_model(const Viewer& viewer) {
  return viewer.crop.asked.gone || viewer.crop.busy;
}

std::string remote_state(const RemoteRun& run) {
  if (!run.problem.empty()) return run.problem;
  if (!run.is_answering) return "connecting";
  return run.paused ? "paused" : "running";
}

std::vector<Fact> remote_facts(const Viewer& viewer) {
  if (!viewer.remote) return {};
  const RemoteRun& run = *viewer.remote;
  std::vector<Fact> facts = {{"training at", run.address}, {"state", remote_state(run)}};
  if (!run.source.empty()) facts.push_back({"its data", run.source});
  if (run.metrics.gaussians && is_count(*run.metrics.gaussians))
    facts.push_back({"Gaussians", grouped(static_cast<std::uint64_t>(*run.metrics.gaussians))});
  if (run.metrics.loss) facts.push_back({"loss", fmt::format("{:.4f}", *run.metrics.loss)});
  if (run.pictures > 0)
    facts.push_back({"pictures", grouped(static_cast<std::uint64_t>(run.pictures))});
  return facts;
}

void require_scene(const Viewer& viewer) {
  if (viewer.remote)
    fail(ErrorKind::usage,
         "this window shows a training in another program, of which it has pictures only");
}

void action::start_training(Viewer& v, Host& host, const TrainingRequest& request) {
  if (v.training && v.training->phase != TrainingPhase::ended)
    return notify_error(v, "a model is being trained: stop that run first");
  v.training = Training();
  host.start_training(request);
}

void action::command_training(Viewer& v, Host& host, TrainingCommand command) {
  if (!v.training || v.training->phase == TrainingPhase::ended) return;
  const bool paused = v.training->phase == TrainingPhase::paused;
  if (command == TrainingCommand::pause && paused) return;
  if (command == TrainingCommand::resume && !paused) return;
  host.train(command);
}

void action::toggle_training(Viewer& v, Host& host) {
  if (v.remote) host.train(v.remote->paused ? TrainingCommand::resume : TrainingCommand::pause);
  const bool paused = v.training && v.training->phase == TrainingPhase::paused;
  command_training(v, host, paused ? TrainingCommand::resume : TrainingCommand::pause);
}

void action::step_test_view(Viewer& v, int by) {
  if (!v.training || !v.training->views) return;
  const int count = static_cast<int>(v.training->views->cameras.size());
  TestView& shown = v.training->test_view;
  const int view = ((static_cast<int>(shown.view) + by) % count + count) % count;
  if (static_cast<std::size_t>(view) == shown.view) return;
  shown = {};
  shown.view = static_cast<std::size_t>(view);
}

void action::training_began(Viewer& v, const std::filesystem::path& folder,
                            const std::shared_ptr<const TestViews>& views) {
  if (!v.training || v.training->phase == TrainingPhase::ended) v.training = Training();
  v.training->folder = folder;
  v.training->views = views;
  v.training->test_view = {};
  v.panels.training = true;
}

void action::training_progressed(Viewer& v, const TrainingProgress& progress) {
  if (!v.training) return;
  Training& training = *v.training;
  if (progress.iteration > training.progress.iteration) {
    training.losses.push_back({progress.iteration, static_cast<float>(progress.loss)});
    if (training.losses.size() > Training::kMostLosses) drop_every_second(training.losses);
  }
  training.progress = progress;
}

void action::training_paused(Viewer& v, bool paused) {
  if (!v.training || v.training->phase == TrainingPhase::ended) return;
  v.training->phase = paused ? TrainingPhase::paused : TrainingPhase::running;
}

void action::training_ended(Viewer& v, const std::string& outcome, bool is_error) {
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

void action::test_photograph_read(Viewer& v, const std::shared_ptr<const TestViews>& views,
                                  std::size_t view,
                                  const std::shared_ptr<const TestPhotograph>& photograph,
                                  const std::shared_ptr<const Image>& shown) {
  TestView* const test_view = shown_test_view(v, views, view);
  if (test_view == nullptr) return;
  test_view->photograph = photograph;
  test_view->shown = shown;
}

void action::test_view_failed(Viewer& v, const std::shared_ptr<const TestViews>& views,
                              std::size_t view, const std::string& problem) {
  if (TestView* const test_view = shown_test_view(v, views, view)) test_view->problem = problem;
}

void action::test_view_compared(Viewer& v, const std::shared_ptr<const TestViews>& views,
                                const TestComparison& comparison, double seconds) {
  if (is_training(v)) v.training->budget.spent(v.now, seconds, DrawingBudget::kResting);
  test_view_given_up(v);
  TestView* const test_view = shown_test_view(v, views, comparison.view);
  if (test_view == nullptr) return;
  test_view->comparison = comparison;
  test_view->compared_at = v.now;
}

void action::test_view_given_up(Viewer& v) {
  if (v.training) v.training->test_view.compares = false;
}

void action::model_shown(Viewer& v, int iteration, std::uint64_t gaussians, double seconds) {
  if (!v.training || !v.scene) return;
  v.training->shown = iteration;
  v.training->budget.spent(v.now, seconds, DrawingBudget::kResting);
  v.scene->gaussians = gaussians;
  v.inspected.reset();
  view_changed(v);
}

void action::remote_opened(Viewer& v, Host& host, const std::string& address,
                           const std::vector<Camera>& cameras) {
  const std::vector<std::filesystem::path> recent = v.recent;
  scene_opened(v, host, {remote_scene(address, cameras), v.settings, v.backend});
  v.recent = recent;  // it is no file
  v.remote = RemoteRun();
  v.remote->address = address;
  v.panels.training = true;
  v.panels.hud = false;
}

void action::remote_reported(Viewer& v, const RemoteRun& run) {
  if (!v.remote) return;
  const bool is_new = !run.problem.empty() && run.problem != v.remote->problem;
  v.remote = run;
  if (v.scene && run.metrics.gaussians && is_count(*run.metrics.gaussians))
    v.scene->gaussians = static_cast<std::uint64_t>(*run.metrics.gaussians);
  if (is_new) notify_error(v, run.problem);
}

}  // namespace qs
