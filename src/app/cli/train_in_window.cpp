// SPDX-License-Identifier: MIT
#include "app/cli/train_in_window.h"

#include <exception>
#include <utility>

#include "app/viewer/render/training_thread.h"
#include "app/viewer/view_options.h"
#include "learn/run/overfitting.h"
#include "learn/run/trainer.h"

namespace qs {
namespace {

TrainingProgress progress_of(const train::RunStatus& status, int iterations,
                             const std::filesystem::path& folder) {
  TrainingProgress progress;
  progress.iteration = status.trainer.iteration();
  progress.iterations = iterations;
  progress.loss = status.loss;
  progress.gaussians = status.trainer.gaussians();
  const auto& rows = status.log.rows;
  for (auto row = rows.rbegin(); row != rows.rend() && !progress.test_psnr; ++row) {
    if (!row->test) continue;
    progress.test_psnr = row->test->psnr;
    progress.test_ssim = row->test->ssim;
    progress.evaluated = row->iteration;
  }
  progress.overfitting = train::overfitting_sentence(status.log, folder);
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

std::string sentence_of(train::RunEnd end) {
  return end == train::RunEnd::finished ? "finished and saved" : "stopped and saved";
}

train::RunEnd train_beside_window(TrainingThread& thread, const train::TrainSettings& settings,
                                  const train::DataSet& data, train::RunOptions options,
                                  std::unique_ptr<train::TrainingModel> model, ThreadPool& pool) {
  thread.began(options.out_dir, data.folder, views_for_panel(settings, data));
  options.text.note = [&thread](const std::string& sentence) { thread.tell(sentence); };
  options.watch = [&](const train::RunStatus& status) {
    return thread.after_iteration(progress_of(status, settings.iterations, options.out_dir),
                                  [&] { return status.trainer.cloud(); });
  };
  return train::run_training(settings, data, options, std::move(model), pool);
}

train::RunEnd train_in_window(const train::TrainSettings& settings, const train::DataSet& data,
                              train::RunOptions options,
                              std::unique_ptr<train::TrainingModel> model, ThreadPool& pool,
                              ViewOptions view) {
  std::exception_ptr error;
  train::RunEnd end = train::RunEnd::interrupted;
  view.train = [&](TrainingThread& thread) {
    try {
      end = train_beside_window(thread, settings, data, options, std::move(model), pool);
      return sentence_of(end);
    } catch (...) {
      error = std::current_exception();
      throw;
    }
  };
  run_viewer(view);
  if (error) std::rethrow_exception(error);
  return end;
}

}  // namespace qs
