// SPDX-License-Identifier: MIT
//
// quadsplat train: photographs with cameras -> a folder with a trained model.
#include <memory>

#include "app/cli/command.h"
#include "app/cli/serve_options.h"
#include "app/cli/shared_options.h"
#include "app/cli/shown_run.h"
#include "app/report/train_page.h"
#include "app/serve/served_training.h"
#include "app/viewer/view_options.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "base/quit_signals.h"
#include "base/text.h"
#include "base/warn.h"
#include "learn/run/train_options.h"
#include "learn/step/training_model.h"

namespace qs {
namespace {

struct TrainCommand : train::TrainOptions {
  ViewOptions view;
  ServeOptions serve;
  bool in_window = false, in_browser = false;
  std::optional<Backend> backend;  // unset: the best backend that works
  int device = kFirstGpu, threads = 0;
};

Backend backend_of(const TrainCommand& command) {
  return command.backend ? *command.backend : available_backends().front();
}

train::PreparedRun prepare(TrainCommand& command, ThreadPool& pool, const Progress& progress) {
  command.run.write_page = train::write_train_page;
  return train::prepare(command, backend_of(command), command.device, pool, progress);
}

PageFacts page_of(const TrainCommand& command) {
  PageFacts page{backend_of(command), command.device, command.threads, {}};
  page.settings.mode = command.settings.mode;
  return page;
}

void print_continuation(const char* what, Arguments arguments) {
  std::string again = "quadsplat train";
  for (const std::string& word : arguments)
    if (word != "--resume") again += " " + shell_word(word);
  fmt::print("{}; to continue: {} --resume\n", what, again);
}

// Null without --serve.
std::unique_ptr<Server> make_server(TrainCommand& command, Arguments arguments) {
  if (command.in_browser && command.in_window)
    fail(ErrorKind::usage, "train: --serve and --view exclude each other");
  const char* const option = given_option(arguments, kServeOptions);
  if (option != nullptr && !command.in_browser)
    fail(ErrorKind::usage, "train: {}: needs --serve", option);
  if (!command.in_browser) return nullptr;
  complete(command.serve);
  auto server = make_server(command.serve);
  for (const std::string& sentence : server->warnings()) warn(sentence);
  return server;
}

// Returns after the window was closed and the model was saved.
train::RunEnd train_in_window(TrainCommand& command, ShownRun& run) {
  ViewOptions& view = command.view;
  view.frame.modes = {command.settings.mode};
  view.frame.threads = command.threads;
  view.train = [&](TrainingThread& thread) { return run.train(thread); };
  view.train_request = train_request_in_window;
  run_viewer(view);
  return run.end();
}

// Returns after the run has ended. `interrupted`: by a signal.
train::RunEnd train_in_browser(const TrainCommand& command, ShownRun& run, Server& server) {
  {
    const QuitSignals signals;
    TrainingThread thread([] {}, [&](TrainingThread& own) { return run.train(own); });
    ServedTraining training(thread);
    ServedScenes scenes;
    const auto pass_on_signal = [&] {
      if (QuitSignals::arrived()) thread.command(TrainingCommand::stop);
    };
    const auto serve_page = [&] {
      auto scene = training.open(page_of(command), QuitSignals::arrived);
      if (!scene) return;
      scenes.push_back(std::move(scene));
      print_address(command.serve, server.port(), "the training");
      const auto ends = [&] {
        pass_on_signal();
        return training.has_ended();
      };
      server.run(scenes, ends, &training);
    };
    const auto tell = [](const std::string& sentence) { warn("train: --serve: " + sentence); };
    training.outlive(serve_page, tell, pass_on_signal);
  }
  return run.end();
}

int run(TrainCommand& command, Arguments arguments) {
  const auto server = make_server(command, arguments);  // before the photographs are read
  ThreadPool pool(command.threads);
  ProgressBar bar("reading photographs");
  train::PreparedRun prepared = prepare(command, pool, bar.progress());
  bar.hide();
  ShownRun shown(command, prepared, pool);
  const train::RunEnd end = command.in_window ? train_in_window(command, shown)
                            : server          ? train_in_browser(command, shown, *server)
                                     : run_training(command.settings, prepared.data, command.run,
                                                    std::move(prepared.model), pool);
  if (end == train::RunEnd::finished) return kExitOk;
  print_continuation(command.in_window ? "stopped" : "interrupted", arguments);
  if (command.in_window) return kExitOk;
  throw Cancelled{};
}

void declare_options(Options& options, TrainCommand& command) {
  train::declare_train_options(options, command);
  declare_backend_option(options, command.backend,
                         "the backend that trains; another may continue a run, to other bits");
  declare_device_option(options, command.device);
  declare_threads_option(options, command.threads);
  options.flag("--view", command.in_window,
               "shows the model in the window while it is trained; closing the window saves it");
  declare_window_options(options, command.view);
  options.flag("--serve", command.in_browser,
               "shows the model in a browser while it is trained, as quadsplat serve does");
  command.serve.command = "train";
  declare_serve_options(options, command.serve, {"127.0.0.1"});
  options.example("quadsplat train garden/ --images images_4 --out-dir garden_model",
                  "a model of 30,000 iterations");
  options.example("quadsplat train plush/ --resolution-scale 4 --iterations 1000 --out-dir quick",
                  "a quick look on the CPU");
}

}  // namespace

CommandAction train_command(Options& options) {
  const auto command = std::make_shared<TrainCommand>();
  declare_options(options, *command);
  return [command](Arguments arguments) { return run(*command, arguments); };
}

std::string train_request_in_window(TrainingThread& thread, const TrainingRequest& request) {
  // The command's own options check the words.
  std::vector<std::string> words = {request.data, "--out-dir", request.model};
  words.insert(words.end(), request.options.begin(), request.options.end());
  TrainCommand command;
  Options options("train", "");
  declare_options(options, command);
  if (!options.parse(words)) fail(ErrorKind::usage, "train: --help is printed in the terminal");
  ThreadPool pool(command.threads);
  train::PreparedRun prepared = prepare(command, pool, thread.reading(command.data.data));
  return ShownRun(command, prepared, pool).train(thread);
}

}  // namespace qs
