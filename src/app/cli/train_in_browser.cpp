// SPDX-License-Identifier: MIT
#include "app/cli/train_in_browser.h"

#include <exception>
#include <utility>

#include "app/cli/serve_options.h"
#include "app/cli/train_in_window.h"
#include "base/quit_signals.h"

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
    if (auto scene = training.open(page, QuitSignals::arrived)) {
      scenes.push_back(std::move(scene));
      print_address(serve, server.port(), "the training");
      const auto ends = [&] {
        if (QuitSignals::arrived()) thread.command(TrainingCommand::stop);
        return training.has_ended();
      };
      server.run(scenes, ends, &training);
    }
  }
  if (error) std::rethrow_exception(error);
  return end;
}

}  // namespace qs
