// SPDX-License-Identifier: MIT
//
// quadsplat train: photographs with cameras -> a folder with a trained model.
#include <memory>

#include "app/cli/command.h"
#include "app/cli/serve_options.h"
#include "app/cli/shared_options.h"
#include "app/cli/train_in_browser.h"
#include "app/cli/train_in_window.h"
#include "app/report/train_page.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "learn/run/train_options.h"
#include "learn/step/training_model.h"

namespace qs {
namespace {

struct TrainCommand : train::TrainOptions {
  ViewOptions view;
  ServeChoice serve;
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
  PageFacts page;
  page.backend = backend_of(command);
  page.device = command.device;
  page.threads = command.threads;
  page.settings.mode = command.settings.mode;
  return page;
}

void print_continuation(const char* what, Arguments arguments) {
  std::string again = "quadsplat train";
  for (const std::string& word : arguments) {
    if (word != "--resume") again += " " + shell_word(word);
  }
  fmt::print("{}; to continue: {} --resume\n", what, again);
}

// The options of --serve; unset without it.
std::optional<ServeOptions> serve_options(const TrainCommand& command) {
  if (command.in_browser && command.in_window)
    fail(ErrorKind::usage, "train: --serve and --view exclude each other");
  if (command.in_browser) return serve_options(command.serve, "train");
  if (const char* const option = command.serve.given())
    fail(ErrorKind::usage, "train: {}: needs --serve", option);
  return {};
}

int run(TrainCommand& command, Arguments arguments) {
  const std::optional<ServeOptions> serve = serve_options(command);
  std::optional<Server> server;  // listens before the photographs are read
  if (serve) print_warnings(server.emplace(*serve));
  ThreadPool pool(command.threads);
  ProgressBar bar("reading photographs");
  auto [model, data] = prepare(command, pool, bar.progress());
  bar.hide();
  if (command.in_window) {
    ViewOptions& view = command.view;
    view.frame.modes = {command.settings.mode};
    view.frame.threads = command.threads;
    view.train_request = train_request_in_window;
    if (train_in_window(command.settings, data, command.run, std::move(model), pool, view) ==
        train::RunEnd::interrupted)
      print_continuation("stopped", arguments);
    return kExitOk;
  }
  const train::RunEnd end =
      server ? train_in_browser(command.settings, data, command.run, std::move(model), pool,
                                *server, *serve, page_of(command))
             : run_training(command.settings, data, command.run, std::move(model), pool);
  if (end == train::RunEnd::interrupted) {
    print_continuation("interrupted", arguments);
    throw Cancelled{};
  }
  return kExitOk;
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
  auto [model, data] = prepare(command, pool, thread.reading(command.data.data));
  return sentence_of(
      train_beside_window(thread, command.settings, data, command.run, std::move(model), pool));
}

}  // namespace qs
