// SPDX-License-Identifier: MIT
#include "learn/run/train_options.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string>
#include <vector>

#include "base/fail.h"
#include "base/list_of.h"
#include "base/path_kind.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/scene/reader.h"
#include "learn/run/model_folder.h"
#include "learn/run/render_options.h"
#include "learn/run/strategy.h"
#include "raster/scene/place.h"

namespace qs::train {
namespace {

// The model's Gaussians with the SH degree of the settings.
Parameters read_initial(const std::filesystem::path& path, int sh_degree, ThreadPool& pool,
                        const glm::dvec3& origin, const Progress& progress, const RunText& text) {
  ProgressBar bar("reading");
  bar.appear(text.has_bars);
  ReadOptions reading;
  reading.progress = {bar.progress().report, progress.stop};
  Scene scene = read_scene(path, pool, reading);
  place(scene.cloud, origin);
  bar.hide();
  for (const std::string& warning : scene.warnings) text.warning("warning: " + warning);
  const Parameters read = from_cloud(scene.cloud);
  Parameters result = read;
  result.sh_degree = sh_degree;
  result.sh.assign(result.size() * result.sh_stride(), glm::vec3(0));
  const std::size_t shared = std::min(result.sh_stride(), read.sh_stride());
  for (std::size_t i = 0; i < result.size(); ++i)
    std::copy_n(&read.sh[i * read.sh_stride()], shared, &result.sh[i * result.sh_stride()]);
  return result;
}

// "; 25,784 points of sparse/0/points3D.bin": where the Gaussians come from.
std::string start_text(const TrainOptions& options, const DataSet& data) {
  if (options.run.resume) return "; the run's own Gaussians";
  if (options.init) return fmt::format("; the Gaussians of {}", options.init->string());
  const std::string file = data.points_file.string();
  if (data.points.empty())
    return fmt::format("; {} random points{}",
                       grouped(static_cast<std::uint64_t>(options.random_points)),
                       file.empty() ? "" : ", because " + file + " has none");
  const std::string repeated =
      fmt::format(", {} repeated points merged", grouped(data.repeated_points));
  return fmt::format("; {} of {}{}", counted(data.points.size(), "point"), file,
                     data.repeated_points > 0 ? repeated : "");
}

// Says which data is used.
DataSet read_data(const TrainOptions& options, ThreadPool& pool, const Progress& progress) {
  DataSet data = read_data_set(options.data, pool, progress);
  for (const std::string& sentence : data.warnings) options.run.text.warning(sentence);
  if (data.origin != glm::dvec3(0))
    options.run.text.warning(fmt::format(
        "{}: georeferenced: the model counts from {}, which its cameras.json and its .ply say",
        options.data.data.string(), format_origin(data.origin)));
  data.published_extent = options.settings.published_extent;
  if (const auto far = outliers(data.training_cameras()); !far.empty())
    options.run.text.warning(fmt::format(
        "{} of {} training cameras {} far away from all others, the first is {}{}", far.size(),
        data.training.size(), far.size() == 1 ? "is" : "are",
        data.training[far.front()].camera.name,
        data.published_extent
            ? ""
            : "; such cameras do not count for the extent (with --extent published they do)"));
  options.run.text.result(data.used + start_text(options, data) +
                          (data.left_out.empty() ? "" : "; " + data.left_out));
  return data;
}

// Every strategy names the options that it does not read.
void check_strategy(const TrainOptions& options) {
  const TrainSettings& settings = options.settings;
  const std::string& strategy = settings.strategy;
  const auto require = [&](bool given, const char* option,
                           const std::vector<std::string>& readers) {
    if (given && std::ranges::find(readers, strategy) == readers.end())
      fail(ErrorKind::usage, "{}: is for --strategy {}, not {}", option, joined(readers, " or "),
           strategy);
  };
  require(options.many_gaussians.has_value(), "--gaussians", {"paced", "fastgs"});
  require(options.gaussians.has_value(), "--gaussians N", {"paced"});
  require(settings.seconds > 0, "--seconds", {"paced"});
  require(options.pace.has_value(), "--pace", {"paced"});
  require(settings.guard, "--guard", {"paced"});
  require(settings.sum_gradients, "--sum-gradients", {"fastgs"});
  require(settings.absolute_gradients, "--absolute-gradients", {"adc"});
  require(settings.final_prunes, "--final-prunes", {"adc", "mcmc"});
  require(options.dash_of_paper.has_value(), "--dash-variant", {"dash"});
  require(settings.color_field, "--color-field", {"mask"});
}

// A run has one of three lengths: iterations, seconds, or the pace of another run.
void read_schedule(TrainOptions& options) {
  TrainSettings& settings = options.settings;
  const char* const others[] = {options.iterations ? "--iterations" : nullptr,
                                settings.seconds > 0 ? "--seconds" : nullptr,
                                options.pace ? "--pace" : nullptr};
  const char* first = nullptr;
  for (const char* const given : others) {
    if (given != nullptr && first != nullptr)
      fail(ErrorKind::usage, "{}: contradicts {}", given, first);
    if (given != nullptr) first = given;
  }
  settings.iterations = options.iterations.value_or(settings.iterations);
  if (settings.reduced_photographs && (settings.seconds > 0 || options.pace))
    fail(ErrorKind::usage, "--resolution-schedule dash: contradicts {}", first);
  if (options.pace) settings.pace = read_pace(*options.pace);
}

// Sets the length of a run and the number of Gaussians of `paced` from the data, unless they were
// given.
void follow_data(const TrainOptions& options, const DataSet& data, TrainSettings& settings) {
  const Strategy& strategy = find_strategy(settings.strategy);
  const bool has_length = options.iterations || settings.seconds > 0 || options.pace;
  if (!has_length && strategy.usual_iterations != nullptr)
    settings.iterations = strategy.usual_iterations(data.training.size());
  if (settings.strategy != "paced") return;
  const RunFacts facts = run_facts_of(data, settings.given_pace());
  if (options.many_gaussians)
    settings.max_gaussians =
        std::max<std::size_t>(1, *options.many_gaussians ? 2 * paced_target(settings, facts)
                                                         : paced_target(settings, facts) / 2);
}

// "paced: 5,880 iterations, 201,600 Gaussians"; a start that has more keeps its number.
void tell_paced(const TrainOptions& options, const DataSet& data) {
  const TrainSettings& settings = options.settings;
  const RunFacts facts = run_facts_of(data, settings.given_pace());
  const std::size_t target = paced_target(settings, facts);
  const std::size_t start = options.run.initial   ? options.run.initial->size()
                            : data.points.empty() ? settings.random_points
                                                  : data.points.size();
  const bool grows = options.run.resume || start < target;
  const std::string length =
      settings.seconds > 0 ? fmt::format("{:g} s", settings.seconds)
                           : counted(static_cast<std::uint64_t>(facts.pace.end()), "iteration");
  options.run.text.result(fmt::format("paced: {}, {}{}", length,
                                      counted(grows ? target : start, "Gaussian"),
                                      grows ? "" : ", as at the start"));
}

void declare_data_options(OptionTable& table, TrainOptions& options) {
  table.positional(kDataOption, options.data.data,
                   "data set: a COLMAP folder, or one with transforms.json or cameras.json",
                   {".", "missing"});
  table.text("--images", "DIR", options.data.images,
             "folder of the photographs in DATA, named as the cameras (default: as transforms.json "
             "names them, else images)",
             {"images", "missing"});
  table.text("--masks", "DIR", options.data.masks,
             "folder of masks in DATA, named NAME.png or NAME.jpg.png: black pixels do not count "
             "(default: the mask_path of transforms.json, else masks, if it exists)",
             {"covers", "missing"});
  table.integer("--resolution-scale", "N", 1, 64, options.data.resolution_scale,
                "trains at 1/N of the photographs' size (default: 1, but at most 1600 pixels "
                "wide)");
  table.integer("--holdout", "N", 0, 1'000'000, options.data.holdout,
                "every N-th photograph by name, from the first, is a test view; 0 = none "
                "(default: 8)");
}

void declare_strategy_options(OptionTable& table, TrainOptions& options) {
  TrainSettings& settings = options.settings;
  settings.strategy = default_strategy().name;
  table.named("--strategy", list_of<std::string>(strategies(), &Strategy::name), settings.strategy,
              "how Gaussians are added and removed (default: paced)");
  table.value(
      "--gaussians", "few|many|N",
      "number of Gaussians at the end, with strategy paced; few is half of the default, a "
      "Gaussian for every 200 pixels of the training photographs, many is twice as many; with "
      "strategy fastgs few, or many for quality (default: few)",
      {"few", "20000"}, [&options](const std::string& given) {
        if (given == "few" || given == "many")
          options.many_gaussians = given == "many";
        else
          options.gaussians = parse_integer("--gaussians", given, 1, 100'000'000);
      });
  table.offers({"few", "many"});
  table.enumerated("--dash-variant", std::array{"current", "2025-06"}, options.dash_of_paper,
                   "with strategy dash: as published now, or in June 2025 (default: current)");
  table.enumerated(
      "--resolution-schedule", std::array{"full", "dash"}, options.reduces_photographs,
      "size of the photographs in the first iterations: full, or reduced at first as by strategy "
      "dash (default: full, with strategy dash: dash)");
  table.flag("--color-field", settings.color_field,
             "with strategy mask: a hash grid and a network compute colours, as in Compact-3DGS");
  table.flag("--absolute-gradients", settings.absolute_gradients,
             "with strategy adc: splits large Gaussians by absolute gradients (AbsGS)");
  table.flag("--sum-gradients", settings.sum_gradients,
             "with strategy fastgs: steps use the gradients of several iterations: 16 for colours "
             "that depend on the direction; after iteration 15000 32 and then 64 for all values");
  table.flag("--final-prunes", settings.final_prunes,
             "with strategy adc or mcmc: removes faint Gaussians in iterations 18000, 21000, 24000 "
             "and 27000, as fastgs does");
  table.integer("--max-gaussians", "N", 1, 100'000'000, options.max_gaussians,
                "adds no Gaussians beyond N (default: mcmc 1000000, others no limit)");
  table.enumerated(
      "--count-views", kCountViewsNames, settings.count_views,
      "views that count when gradients are averaged over them: exact = mode exact lists the "
      "Gaussian; mode = the training frames' mode does, as published with it (default: exact)");
  table.choice(
      "--extent", {"robust", "published"},
      [&settings](int chosen) { settings.published_extent = chosen == 1; },
      "the scene's extent, the unit of the steps of means: without cameras far away from all "
      "others, "
      "or of all cameras as published (default: robust)");
  table.flag("--guard", settings.guard,
             "with strategy paced: reserves a twentieth of the training views at first, and stops "
             "growth if they get worse");
  table.flag("--step-before-densify", settings.step_before_densify,
             "also takes the optimizer's step in iterations after which Gaussians are added, as "
             "QuadBox's code; 3DGS leaves it out");
}

void declare_model_options(OptionTable& table, TrainOptions& options) {
  TrainSettings& settings = options.settings;
  table.real("--opacity-rate", "X", 1e-6, 1, settings.opacity_rate,
             "learning rate of opacity (default: mcmc and mask 0.05, others 0.025)");
  table.text("--init", "MODEL", options.init,
             "starts from the Gaussians of a model instead of the data set's points",
             {"scene.ply", "missing.ply"});
  table.integer("--random-points", "N", 1, 10'000'000, options.random_points,
                "points to start from if the data set has none (default: 100000)");
  declare_sh_degree_option(table, settings.sh_degree, "3");
  declare_background_option(
      table, [&settings](const glm::vec3& color) { settings.background = color; }, "black",
      &settings.random_background);
  table.choice(
      "--antialiased", {"on", "off"},
      [&settings](int chosen) { settings.antialiased = chosen == 0; },
      "trains with the opacity compensation of Mip-Splatting (default: off)");
  table.integer(
      "--iterations", "N", 1, 10'000'000, options.iterations,
      "training steps (default: with strategy paced 70 for each training view, from 3000 to "
      "30000; else 30000)");
  table.real("--seconds", "S", 0.1, 1e6, settings.seconds,
             "with strategy paced: trains for S seconds, without evaluations; the number of "
             "iterations follows from the measured speed");
  table.text("--pace", "FILE", options.pace,
             "with strategy paced: repeats the schedule of a run with --seconds, and with the same "
             "other options its model, from its train.json",
             {"train.json", "missing.json"});
  table.integer("--seed", "N", 0, 2'147'483'647, settings.seed,
                "of all random numbers (default: 0)");
}

}  // namespace

void declare_train_options(OptionTable& table, TrainOptions& options) {
  declare_data_options(table, options);
  table.text(kModelOption, "DIR", options.run.out_dir,
             "folder of the trained model, which every command opens", {"trained"});
  table.required();
  declare_mode_option(
      table, "--cull", [&options](CullMode mode) { options.settings.mode = mode; },
      fmt::format("tile culling mode of the training frames (default: {})",
                  mode_name(default_mode())));
  declare_strategy_options(table, options);
  declare_model_options(table, options);
  table.flag("--resume", options.run.resume,
             "continues the run that was saved in MODEL with the same options, to the same bits as "
             "without a break");
  table.overwrite(&options.run.overwrite);
  table.integer("--eval-every", "N", 1, 10'000'000, options.run.eval_every,
                "measures PSNR and SSIM on the test views every N iterations (default: at the "
                "end; where the best is kept, as often as takes about 3 % of the time)");
  table.flag("--keep-best", options.keep_best,
             "also saves the Gaussians of the evaluation with the highest PSNR; --iteration N "
             "opens them (default: with fewer than 120 photographs)");
  table.flag("--keep-last", options.keep_last, "does not save the best evaluation");
  table.integer("--save-every", "N", 1, 10'000'000, options.run.save_every,
                "saves the model every N iterations (default: at the end)");
  table.flag("--keep-checkpoint", options.run.keep_checkpoint,
             "keeps the checkpoint of a finished run, so that --resume can continue it with more "
             "--iterations");
  table.converted(
      "--photo-memory", "BYTES", options.data.photo_memory, parse_bytes,
      "memory for photographs, such as 800M or 1.5G: those that do not fit are read again "
      "ahead of their use; the model does not depend on it (default: half of the "
      "machine's memory)",
      {"800M", "1"});
}

PreparedRun prepare(TrainOptions& options, Backend backend, int device, ThreadPool& pool,
                    const Progress& progress) {
  check_strategy(options);
  TrainSettings& settings = options.settings;
  settings.many_gaussians = options.many_gaussians.value_or(false) && settings.strategy == "fastgs";
  settings.dash_of_paper = options.dash_of_paper.value_or(false);
  settings.reduced_photographs =
      options.reduces_photographs.value_or(find_strategy(settings.strategy).reduces_photographs);
  read_schedule(options);
  if (options.keep_best && options.keep_last)
    fail(ErrorKind::usage, "--keep-last: contradicts --keep-best");
  if (options.keep_best || options.keep_last) options.run.keep_best = options.keep_best;
  if (options.gaussians && options.max_gaussians > 0)
    fail(ErrorKind::usage, "--max-gaussians: contradicts --gaussians {}", *options.gaussians);
  settings.max_gaussians =
      static_cast<std::size_t>(options.gaussians.value_or(options.max_gaussians));
  settings.random_points = static_cast<std::size_t>(options.random_points);
  options.data.background = settings.background;
  options.data.keep_alpha = settings.random_background;
  check_folder(options.run.out_dir);
  const std::filesystem::path& given = options.data.data;
  const std::filesystem::path data = is_file(given) ? given.parent_path() : given;
  std::error_code error;
  if (std::filesystem::equivalent(options.run.out_dir, data, error))
    fail(ErrorKind::usage, "train: {}: the model would be written into its data set",
         options.run.out_dir.string());
  require_new_folder(options.run.out_dir, options.run.overwrite || options.run.resume);
  if (options.run.resume && !std::filesystem::exists(checkpoint_path(options.run.out_dir)))
    fail(
        "train: {}: holds no run to continue: leave out --resume to begin one; a finished run "
        "continues only if it had --keep-checkpoint",
        options.run.out_dir.string());
  // Two runs with this folder would end in a sentence only after the photographs were read.
  if (std::filesystem::exists(options.run.out_dir)) lock_model_folder(options.run.out_dir);
  if (settings.color_field) {
    if (settings.antialiased)
      fail(ErrorKind::usage, "--color-field: its files do not hold --antialiased");
    settings.sh_degree = 0;
  }
  PreparedRun prepared;
  prepared.model = make_training_model(backend, pool, device);
  prepared.data = read_data(options, pool, progress);
  follow_data(options, prepared.data, settings);
  if (options.init && !options.run.resume)
    options.run.initial = read_initial(*options.init, settings.sh_degree, pool,
                                       prepared.data.origin, progress, options.run.text);
  if (settings.strategy == "paced") tell_paced(options, prepared.data);
  return prepared;
}

}  // namespace qs::train
