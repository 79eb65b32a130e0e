// SPDX-License-Identifier: MIT
#include "app/cli/train_in_window.h"

#include <exception>
#include <utility>

#include "app/train/trainer.h"
#include "app/viewer/render/training_thread.h"
#include "app/viewer/view_loop.h"

namespace qs {
namespace {

TrainingProgress progress_of(const train::RunStatus& status, int iterations) {
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
  return progress;
}

train::RunWish wish_of(TrainingWish wish) {
  return wish == TrainingWish::stop   ? train::RunWish::stop
         : wish == TrainingWish::save ? train::RunWish::save
                                      : train::RunWish::go_on;
}

}  // namespace

Progress reading_in_window(TrainingThread& thread, const std::filesystem::path& data) {
  return thread.reading(data);
}

std::string sentence_of(train::RunEnd end) {
  return end == train::RunEnd::finished ? "finished and saved" : "stopped and saved";
}

train::RunEnd train_beside_window(TrainingThread& thread, const train::TrainSettings& settings,
                                  const train::DataSet& data, train::RunOptions options,
                                  std::unique_ptr<train::TrainingModel> model, ThreadPool& pool) {
  thread.began(options.out_dir, data.folder);
  options.watch = [&](const train::RunStatus& status) {
    return wish_of(thread.after_iteration(progress_of(status, settings.iterations),
                                          [&] { return status.trainer.cloud(); }));
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
