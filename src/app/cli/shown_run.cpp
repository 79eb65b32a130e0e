// SPDX-License-Identifier: MIT
#include "app/cli/shown_run.h"

#include <cmath>
#include <utility>

#include "app/viewer/render/training_thread.h"
#include "app/viewer/view_options.h"
#include "learn/run/train_log.h"
#include "learn/run/trainer.h"

namespace qs {
namespace {

TrainingProgress progress_of(const train::RunStatus& status, const std::filesystem::path& folder) {
  TrainingProgress progress{.iteration = status.trainer.iteration(),
                            .iterations = status.trainer.last_iteration(),
                            .loss = status.loss,
                            .gaussians = status.trainer.gaussians()};
  const auto& rows = status.log.rows;
  for (auto row = rows.rbegin(); row != rows.rend() && !progress.test_psnr; ++row) {
    if (!row->test) continue;
    progress.test_psnr = row->test->psnr;
    progress.test_ssim = row->test->ssim;
    progress.evaluated = row->iteration;
  }
  progress.overfitting = train::overfitting_sentence(status.log, folder);
  for (const train::LogRow& row : rows)
    if (row.test && std::isfinite(row.test->psnr))
      progress.test_psnrs.push_back({row.iteration, row.test->psnr});
  for (const train::GuardRow& row : status.log.guard)
    progress.reserved_psnrs.push_back({row.iteration, row.reserved});
  progress.guard = status.log.verdict;
  return progress;
}

// The views that the trainer evaluates; without these, the views that it trains from.
std::shared_ptr<const TestViews> views_for_panel(const train::TrainSettings& settings,
                                                 const train::DataSet& data) {
  const auto views = std::make_shared<TestViews>();
  views->held_out = !data.test.empty();
  views->settings.mode = settings.mode;
  views->settings.antialiased = settings.antialiased;
  views->settings.background = settings.random_background ? glm::vec3(0) : settings.background;
  std::vector<train::PhotographSource> sources;
  for (const train::PhotographView& view : views->held_out ? data.test : data.training) {
    views->cameras.push_back(view.camera);
    sources.push_back(view.source);
  }
  // It may be called after the end of the run, when the data set is gone.
  views->read = [sources = std::move(sources)](std::size_t view) {
    ThreadPool pool(1);
    const train::PhotographView photograph = train::read_view(sources[view], pool);
    return TestPhotograph{photograph.image(), photograph.mask};
  };
  return views;
}

}  // namespace

std::string ShownRun::train(TrainingThread& thread) try {
  const train::TrainSettings& settings = options_.settings;
  train::RunOptions run = options_.run;
  thread.began(run.out_dir, prepared_.data.folder, views_for_panel(settings, prepared_.data));
  run.text.note = [&thread](const std::string& sentence) { thread.tell(sentence); };
  run.watch = [&](const train::RunStatus& status) {
    return thread.after_iteration(progress_of(status, run.out_dir),
                                  [&] { return status.trainer.cloud(); });
  };
  end_ = train::run_training(settings, prepared_.data, run, std::move(prepared_.model), pool_);
  return end_ == train::RunEnd::finished ? "finished and saved" : "stopped and saved";
} catch (...) {
  error_ = std::current_exception();
  throw;
}

train::RunEnd ShownRun::end() const {
  if (error_) std::rethrow_exception(error_);
  return end_;
}

}  // namespace qs
