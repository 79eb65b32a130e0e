// SPDX-License-Identifier: MIT
#include "app/cli/train_in_browser.h"

#include <exception>
#include <utility>

#include "app/cli/serve_options.h"
#include "app/cli/train_in_window.h"
#include "base/quit_signals.h"
#include "base/warn.h"

namespace qs {

train::RunEnd train_in_browser(const train::TrainSettings& settings, const train::DataSet& data,
                               train::RunOptions options,
                               std::unique_ptr<train::TrainingModel> model, ThreadPool& pool,
                               Server& server, const ServeOptions& serve, const PageFacts& page) {
  std::exception_ptr error;
  train::RunEnd end = train::RunEnd::interrupted;
  {
    const QuitSignals signals;
    TrainingThread thread([] {},
                          [&](TrainingThread& own) {
                            try {
                              end = train_beside_window(own, settings, data, options,
                                                        std::move(model), pool);
                              return sentence_of(end);
                            } catch (...) {
                              error = std::current_exception();
                              throw;
                            }
                          });
    ServedTraining training(thread);
    ServedScenes scenes;
    const auto pass_on_signal = [&] {
      if (QuitSignals::arrived()) thread.command(TrainingCommand::stop);
    };
    const auto serve_page = [&] {
      auto scene = training.open(page, QuitSignals::arrived);
      if (!scene) return;
      scenes.push_back(std::move(scene));
      print_address(serve, server.port(), "the training");
      const auto ends = [&] {
        pass_on_signal();
        return training.has_ended();
      };
      server.run(scenes, ends, &training);
    };
    const auto tell = [](const std::string& sentence) { warn("train: --serve: " + sentence); };
    training.outlive(serve_page, tell, pass_on_signal);
  }
  if (error) std::rethrow_exception(error);
  return end;
}

}  // namespace qs
