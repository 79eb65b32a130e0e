// SPDX-License-Identifier: MIT
//
// quadsplat train: photographs with cameras -> a folder with a trained model.
#include <cstdio>
#include <memory>

#include "app/base/progress_bar.h"
#include "app/base/text.h"
#include "app/cli/command.h"
#include "app/cli/serve_options.h"
#include "app/cli/shared_options.h"
#include "app/cli/train_in_browser.h"
#include "app/cli/train_in_window.h"
#include "app/serve/token.h"
#include "app/session/photographs.h"
#include "app/session/session.h"
#include "app/train/model_folder.h"
#include "app/train/run.h"
#include "app/train/strategy.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "raster/api/training_model.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

struct TrainCommand {
  train::DataOptions data;
  train::TrainSettings settings;
  train::RunOptions run;
  ViewOptions view;
  ServeOptions serve;
  bool in_window = false, in_browser = false, amount_is_set = false, variant_is_set = false;
  bool keep_best = false, keep_last = false;
  std::optional<bool> reduces_photographs;  // unset: as the strategy does
  std::optional<std::filesystem::path> init;
  std::optional<Backend> backend;  // unset: the best backend that works
  int device = kFirstGpu, threads = 0, max_gaussians = 0, random_points = 100'000;
};

// The model's Gaussians with the SH degree of the settings.
train::Parameters read_initial(const std::filesystem::path& path, int sh_degree, ThreadPool& pool) {
  const train::Parameters read = train::from_cloud(load_scene(path, pool).cloud);
  train::Parameters result = read;
  result.sh_degree = sh_degree;
  result.sh.assign(result.size() * result.sh_stride(), glm::vec3(0));
  const std::size_t shared = std::min(result.sh_stride(), read.sh_stride());
  for (std::size_t i = 0; i < result.size(); ++i) {
    for (std::size_t k = 0; k < shared; ++k)
      result.sh[i * result.sh_stride() + k] = read.sh[i * read.sh_stride() + k];
  }
  return result;
}

train::DataSet read_data(const TrainCommand& command, ThreadPool& pool, const Progress& progress) {
  train::DataSet data = train::read_data_set(command.data, pool, progress);
  if (data.skipped > 0) warn(skipped_sentence(data.skipped));
  if (data.without_mask > 0) {
    warn(fmt::format("{} of {} photographs have no mask in {} and count as a whole",
                     data.without_mask, data.training.size() + data.test.size(),
                     data.masks.string()));
  }
  return data;
}

/// The inputs of a run.
struct Prepared {
  std::unique_ptr<train::TrainingModel> model;
  train::DataSet data;
};

// Every strategy names the options that it does not read.
void check_strategy(const TrainCommand& command) {
  const train::TrainSettings& settings = command.settings;
  const auto require = [&](bool given, const char* option, const char* strategies, bool fits) {
    if (given && !fits) {
      fail(ErrorKind::usage, "{}: is for --strategy {}, not {}", option, strategies,
           settings.strategy);
    }
  };
  const bool adc = settings.strategy == "adc", fastgs = settings.strategy == "fastgs";
  const bool dash = settings.strategy == "dash", mcmc = settings.strategy == "mcmc";
  require(command.amount_is_set, "--gaussians", "fastgs", fastgs);
  require(settings.sum_gradients, "--sum-gradients", "fastgs", fastgs);
  require(settings.absolute_gradients, "--absolute-gradients", "adc", adc);
  require(settings.final_prunes, "--final-prunes", "adc or mcmc", adc || mcmc);
  require(command.variant_is_set, "--dash-variant", "dash", dash);
  require(settings.color_field, "--color-field", "mask", settings.strategy == "mask");
}

Prepared prepare(TrainCommand& command, ThreadPool& pool, const Progress& progress) {
  check_strategy(command);
  command.settings.reduced_photographs = command.reduces_photographs.value_or(
      train::find_strategy(command.settings.strategy).reduces_photographs);
  if (command.keep_best && command.keep_last)
    fail(ErrorKind::usage, "--keep-last: contradicts --keep-best");
  if (command.keep_best || command.keep_last) command.run.keep_best = command.keep_best;
  command.settings.max_gaussians = static_cast<std::size_t>(command.max_gaussians);
  command.settings.random_points = static_cast<std::size_t>(command.random_points);
  command.data.background = command.settings.background;
  command.data.keep_alpha = command.settings.random_background;
  check_folder(command.run.out_dir);
  require_new_folder(command.run.out_dir, command.run.overwrite || command.run.resume);
  if (command.run.resume && !std::filesystem::exists(train::checkpoint_path(command.run.out_dir))) {
    fail(
        "train: {}: holds no run to continue: leave out --resume to begin one; a finished run "
        "continues only if it had --keep-checkpoint",
        command.run.out_dir.string());
  }
  // Two runs with this folder would end in a sentence only after the photographs were read.
  if (std::filesystem::exists(command.run.out_dir)) train::lock_model_folder(command.run.out_dir);
  const Backend backend = command.backend.value_or(available_backends().front());
  if (command.settings.color_field) {
    if (command.settings.antialiased)
      fail(ErrorKind::usage, "--color-field: its files do not hold --antialiased");
    command.settings.sh_degree = 0;
  }
  Prepared prepared;
  prepared.model = train::make_training_model(backend, pool, command.device);
  prepared.data = read_data(command, pool, progress);
  if (command.init && !command.run.resume)
    command.run.initial = read_initial(*command.init, command.settings.sh_degree, pool);
  return prepared;
}

void print_continuation(const char* what, Arguments arguments) {
  std::string again = "quadsplat train";
  for (const std::string& word : arguments) {
    if (word != "--resume") again += " " + shell_word(word);
  }
  fmt::print("{}; to continue: {} --resume\n", what, again);
}

// The server of --serve, which listens before the photographs are read.
std::unique_ptr<Server> server_of(TrainCommand& command) {
  const ServeOptions unset;
  ServeOptions& serve = command.serve;
  if (command.in_browser && command.in_window)
    fail(ErrorKind::usage, "train: --serve and --view exclude each other");
  if (!command.in_browser) {
    const auto refuse = [](bool given, const char* option) {
      if (given) fail(ErrorKind::usage, "train: {}: needs --serve", option);
    };
    refuse(serve.port != unset.port, "--port");
    refuse(serve.address != unset.address, "--address");
    refuse(serve.name != unset.name, "--name");
    return {};
  }
  serve.token = make_token();
  auto server = std::make_unique<Server>(serve);
  warn_of_address(serve);
  return server;
}

int run(TrainCommand& command, Arguments arguments) {
  const std::unique_ptr<Server> server = server_of(command);
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
  PageFacts page;
  page.backend = command.backend.value_or(available_backends().front());
  page.device = command.device;
  page.threads = command.threads;
  page.settings.mode = command.settings.mode;
  const train::RunEnd end =
      server ? train_in_browser(command.settings, data, command.run, std::move(model), pool,
                                *server, command.serve, page)
             : run_training(command.settings, data, command.run, std::move(model), pool);
  if (end == train::RunEnd::interrupted) {
    print_continuation("interrupted", arguments);
    throw Cancelled{};
  }
  return kExitOk;
}

void declare_data_options(Options& options, TrainCommand& command) {
  options.positional("DATA", command.data.data,
                     "data set: a COLMAP folder, or one with transforms.json or cameras.json",
                     {".", "missing"});
  options.text("--images", "DIR", command.data.images,
               "folder of the photographs in DATA, named as the cameras (default: images)",
               {"images", "missing"});
  options.text("--masks", "DIR", command.data.masks,
               "folder of masks in DATA, named NAME.png or NAME.jpg.png: black pixels do not count "
               "(default: masks, if it exists)",
               {"covers", "missing"});
  options.integer("--resolution-scale", "N", 1, 64, command.data.resolution_scale,
                  "trains at 1/N of the photographs' size (default: 1, but at most 1600 pixels "
                  "wide)");
  options.integer("--holdout", "N", 0, 1'000'000, command.data.holdout,
                  "every N-th photograph by name, from the first, is a test view; 0 = none "
                  "(default: 8)");
}

void declare_model_options(Options& options, TrainCommand& command) {
  std::vector<std::string> names;
  for (const train::Strategy& strategy : train::strategies()) names.emplace_back(strategy.name);
  train::TrainSettings& settings = command.settings;
  declare_mode_option(
      options, "--cull", [&settings](CullMode mode) { settings.mode = mode; },
      fmt::format("tile culling mode of the training frames (default: {})",
                  mode_name(default_mode())));
  options.choice(
      "--strategy", names,
      [&settings, names](int chosen) {
        settings.strategy = names[static_cast<std::size_t>(chosen)];
      },
      "how Gaussians are added and removed (default: adc, as published with 3DGS)");
  options.choice(
      "--gaussians", {"few", "many"},
      [&settings, &command](int chosen) {
        settings.many_gaussians = chosen == 1;
        command.amount_is_set = true;
      },
      "with strategy fastgs: few Gaussians, or more of them for quality (default: few)");
  options.choice(
      "--dash-variant", {"current", "2025-06"},
      [&settings, &command](int chosen) {
        settings.dash_of_paper = chosen == 1;
        command.variant_is_set = true;
      },
      "with strategy dash: as published now, or in June 2025 (default: current)");
  options.choice(
      "--resolution-schedule", {"full", "dash"},
      [&command](int chosen) { command.reduces_photographs = chosen == 1; },
      "size of the photographs in the first iterations: full, or reduced at first as by strategy "
      "dash (default: full, with strategy dash: dash)");
  options.flag("--color-field", settings.color_field,
               "with strategy mask: a hash grid and a network compute colours, as in Compact-3DGS");
  options.flag("--absolute-gradients", settings.absolute_gradients,
               "with strategy adc: splits large Gaussians by absolute gradients (AbsGS)");
  options.flag(
      "--sum-gradients", settings.sum_gradients,
      "with strategy fastgs: steps use the gradients of several iterations: 16 for colours "
      "that depend on the direction; after iteration 15000 32 and then 64 for all values");
  options.flag(
      "--final-prunes", settings.final_prunes,
      "with strategy adc or mcmc: removes faint Gaussians in iterations 18000, 21000, 24000 "
      "and 27000, as fastgs does");
  options.integer("--max-gaussians", "N", 1, 100'000'000, command.max_gaussians,
                  "adds no Gaussians beyond N (default: mcmc 1000000, others no limit)");
  options.choice(
      "--count-views", {std::begin(train::kCountViewsNames), std::end(train::kCountViewsNames)},
      [&settings](int chosen) { settings.count_views = static_cast<train::CountViews>(chosen); },
      "views that count when gradients are averaged over them: exact = mode exact lists the "
      "Gaussian; mode = the training frames' mode does, as published with it (default: exact)");
  options.flag("--step-before-densify", settings.step_before_densify,
               "also takes the optimizer's step in iterations after which Gaussians are added, as "
               "QuadBox's code; 3DGS leaves it out");
  options.real("--opacity-rate", "X", 1e-6, 1, settings.opacity_rate,
               "learning rate of opacity (default: mcmc and mask 0.05, others 0.025)");
  options.text("--init", "MODEL", command.init,
               "starts from the Gaussians of a model instead of the data set's points",
               {"scene.ply", "missing.ply"});
  options.integer("--random-points", "N", 1, 10'000'000, command.random_points,
                  "points to start from if the data set has none (default: 100000)");
  declare_sh_degree_option(options, settings.sh_degree, "3");
  declare_background_option(
      options, [&settings](const glm::vec3& color) { settings.background = color; }, "black",
      &settings.random_background);
  options.choice(
      "--antialiased", {"on", "off"},
      [&settings](int chosen) { settings.antialiased = chosen == 0; },
      "trains with the opacity compensation of Mip-Splatting (default: off)");
  options.integer("--iterations", "N", 1, 10'000'000, settings.iterations,
                  "training steps (default: 30000)");
  options.value("--seed", "N", "of all random numbers (default: 0)", {"1"},
                [&settings](const std::string& text) {
                  settings.seed =
                      static_cast<std::uint64_t>(parse_integer("--seed", text, 0, 2'147'483'647));
                });
}

void declare_options(Options& options, TrainCommand& command) {
  declare_data_options(options, command);
  options.text("--out-dir", "DIR", command.run.out_dir,
               "folder of the trained model, which every command opens", {"trained"});
  options.required();
  declare_model_options(options, command);
  options.flag(
      "--resume", command.run.resume,
      "continues the run that was saved in MODEL with the same options, to the same bits as "
      "without a break");
  options.overwrite(&command.run.overwrite);
  options.integer("--eval-every", "N", 1, 10'000'000, command.run.eval_every,
                  "measures PSNR and SSIM on the test views every N iterations (default: at the "
                  "end; where the best is kept, as often as takes about 3 % of the time)");
  options.flag("--keep-best", command.keep_best,
               "also saves the Gaussians of the evaluation with the highest PSNR; --iteration N "
               "opens them (default: with fewer than 120 photographs)");
  options.flag("--keep-last", command.keep_last, "does not save the best evaluation");
  options.integer("--save-every", "N", 1, 10'000'000, command.run.save_every,
                  "saves the model every N iterations (default: at the end)");
  options.flag("--keep-checkpoint", command.run.keep_checkpoint,
               "keeps the checkpoint of a finished run, so that --resume can continue it with more "
               "--iterations");
  options.value(
      "--photo-memory", "BYTES",
      "memory for photographs, such as 800M or 1.5G: those that do not fit are read again "
      "ahead of their use; the model does not depend on it (default: half of the "
      "machine's memory)",
      {"800M", "1"}, [&data = command.data](const std::string& text) {
        data.photo_memory = parse_bytes("--photo-memory", text);
      });
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
  auto [model, data] = prepare(command, pool, reading_in_window(thread, command.data.data));
  return sentence_of(
      train_beside_window(thread, command.settings, data, command.run, std::move(model), pool));
}

}  // namespace qs
