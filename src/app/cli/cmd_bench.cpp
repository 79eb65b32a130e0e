// SPDX-License-Identifier: MIT
//
// quadsplat bench: scenes x views x culling modes -> a table, CSV, JSON, Markdown and plots.
// bench_lod.h measures levels of detail instead, and bench_flight.h a flight.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "app/cli/bench_flight.h"
#include "app/cli/bench_lod.h"
#include "app/cli/bench_plugins.h"
#include "app/cli/camera_choice.h"
#include "app/cli/command.h"
#include "app/cli/lens_options.h"
#include "app/framing/up_axis.h"
#include "app/measure/load_times.h"
#include "app/measure/measure_view.h"
#include "app/measure/replicate.h"
#include "app/measure/scene_facts.h"
#include "app/measure/statistics.h"
#include "app/report/bench_report.h"
#include "app/report/environment.h"
#include "app/report/markdown.h"
#include "app/session/alterations.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "io/bytes/file_guard.h"

namespace qs {
namespace {

struct BenchCommand {
  FrameOptions frame;
  std::vector<std::filesystem::path> scenes;
  CameraChoice cameras;
  ViewPlan plan;
  std::optional<CullMode> baseline;  // unset: the default baseline, if it is measured
  std::optional<std::filesystem::path> out_dir;
  std::optional<glm::ivec2> replicate;
  int scaling = 0;
  Shard shard;
  bool psnr = false, load = false, lod = false, flight = false, exact_color = false;
  std::vector<double> budgets;  // of --lod, per cent
  std::vector<std::filesystem::path> plugins;
  LensOptions lens;
  int plugin_timeout = 60;  // s

  bool judges_images() const { return psnr || !plugins.empty(); }
};

int run_load_bench(const BenchCommand& command) {
  std::vector<LoadTimes> rows;
  ThreadPool pool(command.frame.threads);
  ProgressBar bar("reading");
  const Progress progress = bar.progress();
  for (std::size_t i = 0; i < command.scenes.size(); ++i)
    rows.push_back(measure_loading(command.scenes[i], pool, std::max(command.plan.rounds, 5),
                                   step_of(progress, i, command.scenes.size())));
  bar.hide();
  fmt::print("{}", format_load_times(rows));
  return kExitOk;
}

class Bench {
 public:
  Bench(const BenchCommand& command, Arguments arguments)
      : command_(command), flags_(arguments.begin(), arguments.end()) {}

  int run() {
    const int sizes = std::max(command_.scaling, 1);
    parts_ = command_.scenes.size() * static_cast<std::size_t>(sizes);
    for (const std::filesystem::path& path : command_.scenes)
      for (int size = 1; size <= sizes; ++size)
        one_scene(path, command_.scaling > 0 ? glm::ivec2(size)
                                             : command_.replicate.value_or(glm::ivec2(1)));
    report_.view_count = view_;
    add_clock(report_.environment, clock_);
    fmt::print("{}", format_markdown(report_));
    if (const std::string noise = noise_sentence(report_.rows); !noise.empty())
      warn("warning: " + noise);
    if (const std::string throttling = throttle_warning(clock_.summary()); !throttling.empty())
      warn("warning: " + throttling);
    if (command_.out_dir) {
      warn(write_report(report_, *command_.out_dir));
      fmt::print(stderr, "wrote {}\n", command_.out_dir->string());
    }
    return kExitOk;
  }

 private:
  void one_scene(const std::filesystem::path& path, glm::ivec2 copies) {
    FrameOptions frame = command_.frame;
    frame.scene = path;
    if (command_.exact_color) frame.network = NetworkUse::reference;
    const bool grid = copies != glm::ivec2(1);
    Session session = open_session(frame, [&](Scene& scene) {
      if (!grid) return;
      scene.cloud = replicate(scene.cloud, copies, world_up(scene.vertical_axis));
      scene.edits.copies = copies;
    });
    set_lens(command_.lens, frame, session);
    if (report_.environment.is_null()) describe(session);
    std::string name = scene_name(session.scene->path);
    if (grid || command_.scaling > 0) name += fmt::format(" {}x{}", copies.x, copies.y);
    if (is_taken(name)) name += fmt::format(" ({})", report_.scenes.size() + 1);
    report_.scenes.push_back(scene_facts(*session.scene, name));
    alterations_of(session).add_to(report_.scenes.back());
    const std::vector<Shot> views = choose_views(frame, session);
    BenchPlugins plugins(command_.plugins, command_.plugin_timeout, session, name,
                         report_.environment);
    ProgressBar bar(fmt::format("{} ({}/{})", name, report_.scenes.size(), parts_));
    const std::size_t first_row = report_.rows.size();
    for (std::size_t i = 0; i < views.size(); ++i, ++view_) {
      if (!command_.shard.takes(view_)) continue;
      one_view(session, plugins, name, views[i], step_of(bar.progress(), i, views.size()));
    }
    plugins.close();
    if (command_.cameras.holdout > 0) add_paper_times(session, views, first_row, bar);
  }

  // The rows of the scene begin at `first_row`.
  void add_paper_times(Session& session, const std::vector<Shot>& views, std::size_t first_row,
                       ProgressBar& bar) {
    const std::size_t first_view = view_ - views.size();
    std::vector<Camera> cameras;
    std::vector<std::size_t> places(views.size());  // index of each view in `cameras`
    for (std::size_t i = 0; i < views.size(); ++i) {
      places[i] = cameras.size();
      if (command_.shard.takes(first_view + i)) cameras.push_back(views[i].camera);
    }
    bar.relabel(fmt::format("test views ({}/{})", report_.scenes.size(), parts_));
    const auto times =
        paper_times(session, command_.frame.modes, cameras, command_.plan.rounds, bar.progress());
    for (std::size_t i = first_row; i < report_.rows.size(); ++i) {
      BenchRow& row = report_.rows[i];
      const auto& modes = command_.frame.modes;
      const auto mode = std::ranges::find(modes, find_culler(row.mode));
      if (row.backend == kPluginBackend || mode == modes.end()) continue;
      row.ms_paper =
          times[static_cast<std::size_t>(mode - modes.begin())][places[row.view - first_view]];
    }
  }

  void one_view(Session& session, BenchPlugins& plugins, const std::string& name, const Shot& view,
                const Progress& progress) {
    const std::string camera =
        view.number < 0 || command_.cameras.path ? view.origin : fmt::format("{}", view.number);
    ViewPlan plan = command_.plan;
    plan.clock = &clock_;
    plan.first_round = view_;
    plan.guests = plugins.guests();
    plan.guest_failed = [&](const Guest&, const std::string& problem) {
      plugins.note(camera, problem);
    };
    const float measured = command_.judges_images() ? 0.6f : 1.0f;
    std::vector<BenchRow> rows = measure_view(session, command_.frame.modes, view.camera, plan,
                                              part_of(progress, 0, measured));
    for (BenchRow& row : rows) {
      row.scene = name;
      row.camera = camera;
      row.view = view_;
    }
    if (command_.judges_images()) {
      const Image truth = reference_image(session, view.camera, part_of(progress, measured, 0.95f));
      judge_images(session, plugins, view.camera, truth, rows);
    }
    report_.rows.insert(report_.rows.end(), rows.begin(), rows.end());
  }

  std::vector<Shot> choose_views(const FrameOptions& frame, const Session& session) const {
    if (command_.scaling > 0) return {overview_shot(frame, *session.scene)};
    return choose_shots_or_all(command_.cameras, frame, session);
  }

  // Renders again, because measured images stay on the device. The row of a plugin that fails here
  // is removed, because its times belong to another picture.
  void judge_images(Session& session, BenchPlugins& plugins, const Camera& camera,
                    const Image& truth, std::vector<BenchRow>& rows) const {
    RenderSettings settings = session.settings;
    std::erase_if(rows, [&](BenchRow& row) {
      Renderer* const guest = plugins.find(row.mode);
      if (guest == nullptr) settings.mode = find_culler(row.mode);
      Renderer& renderer = guest != nullptr ? *guest : *session.renderer;
      try {
        judge_quality(renderer, camera, settings, truth, *session.pool, row);
      } catch (const Error& error) {
        if (guest == nullptr) throw;
        plugins.note(row.camera, error.what());
        return true;
      }
      return false;
    });
  }

  // Rows are grouped by the scene's name, but two files may have the same name.
  bool is_taken(const std::string& name) const {
    return std::ranges::any_of(report_.scenes,
                               [&](const auto& scene) { return scene["name"] == name; });
  }

  void describe(const Session& session) {
    report_.environment = environment_json(session);
    clock_ = clock_of(session);
    report_.environment["flags"] = flags_;
    report_.environment["frames"] = command_.plan.frames;
    report_.environment["warmup"] = command_.plan.warmup;
    report_.environment["rounds"] = command_.plan.rounds;
    if (command_.baseline) report_.environment["baseline"] = mode_name(*command_.baseline);
    report_.environment["scaling"] = command_.scaling > 0;
    report_.scenes = nlohmann::ordered_json::array();
  }

  const BenchCommand& command_;
  std::vector<std::string> flags_;
  BenchReport report_;
  GpuClock clock_;
  std::size_t view_ = 0;   // number of the next (scene, camera)
  std::size_t parts_ = 0;  // scenes to load
};

void check_bench(const BenchCommand& command) {
  const CameraChoice& cameras = command.cameras;
  const std::vector<CullMode>& modes = command.frame.modes;
  const bool chooses = cameras.path || !cameras.indices.empty();
  const bool scales = command.scaling > 0, copies = scales || command.replicate;
  check_rules(
      "bench",
      {{scales && (command.replicate || cameras.path),
        "--scaling excludes --replicate and --camera-path"},
       {cameras.path && !cameras.indices.empty(), "--camera-path excludes --camera-index"},
       {cameras.holdout > 0 && (scales || chooses),
        "--holdout chooses the views: it excludes --camera-index, --camera-path and --scaling"},
       {command.exact_color && (!command.judges_images() || copies),
        "--exact-color needs --psnr or --plugin, whose reference it changes, and excludes "
        "--replicate and --scaling"},
       {copies && command.frame.levels.given(),
        "--replicate and --scaling copy whole scenes: they exclude --budget and --lod-error"},
       {command.baseline && std::ranges::count(modes, *command.baseline) == 0,
        fmt::format("--baseline {0} is not measured: add {0} to --cull",
                    mode_name(command.baseline.value_or(default_mode())))},
       {command.load &&
            (!command.plugins.empty() || chooses || cameras.holdout > 0 || command.out_dir),
        "--load measures reading alone: it excludes --plugin, --camera-index, --camera-path, "
        "--holdout and --out-dir"},
       {command.flight && (command.lod || !cameras.path),
        "--flight flies along a --camera-path; it excludes --lod"},
       {cameras.steps && !cameras.path, "--path-steps needs a --camera-path"},
       {!command.plugins.empty() && command.lens.is_drawn(), "--plugin draws without a --lens"},
       {!command.budgets.empty() && !command.lod, "--budgets needs --lod"}});
}

bool given(Arguments arguments, const char* option) {
  return given_option(arguments, {&option, 1}) != nullptr;
}

// The frame options of --lod and --flight, which draw in one mode and exclude other options.
FrameOptions in_one_mode(const BenchCommand& command, Arguments arguments, const char* option,
                         const char* subject, std::vector<const char*> excluded) {
  for (const char* name :
       {"--rounds", "--baseline", "--load", "--psnr", "--exact-color", "--plugin",
        "--plugin-timeout", "--replicate", "--scaling", "--shard", "--lens"})
    excluded.push_back(name);
  if (const char* const other = given_option(arguments, excluded))
    fail(ErrorKind::usage, "bench: {} measures {}: it excludes {}", option, subject, other);
  FrameOptions frame = command.frame;
  frame.scene = command.scenes.front();
  if (!given(arguments, "--cull")) frame.modes = {default_mode()};
  if (frame.modes.size() > 1)
    fail(ErrorKind::usage, "bench: {} draws in one mode: choose one with --cull", option);
  note_inputs(frame);
  return frame;
}

int run_lod(const BenchCommand& command, Arguments arguments) {
  LodBench bench;
  bench.frame =
      in_one_mode(command, arguments, "--lod", "levels of detail", {"--budget", "--lod-error"});
  bench.cameras = command.cameras;
  bench.others.assign(command.scenes.begin() + 1, command.scenes.end());
  bench.frame.levels = {};
  bench.budgets = command.budgets;
  if (bench.budgets.empty()) bench.budgets = {5, 10, 25, 50};
  if (given(arguments, "--frames")) bench.frames = command.plan.frames;
  if (given(arguments, "--warmup")) bench.warmup = command.plan.warmup;
  bench.out_dir = command.out_dir;
  check_report(bench.out_dir, kLodFiles);
  run_lod_bench(bench);
  return kExitOk;
}

int run_flight(const BenchCommand& command, Arguments arguments) {
  const FrameOptions frame =
      in_one_mode(command, arguments, "--flight", "a flight",
                  {"--frames", "--warmup", "--path-steps", "--camera-index", "--holdout"});
  if (command.scenes.size() > 1) fail(ErrorKind::usage, "bench: --flight: name one scene");
  check_report(command.out_dir, kFlightFiles);
  bench_flight(frame, *command.cameras.path, command.out_dir);
  return kExitOk;
}

int run(const BenchCommand& command, Arguments arguments) {
  check_bench(command);
  if (command.flight) return run_flight(command, arguments);
  if (command.lod) return run_lod(command, arguments);
  for (const std::filesystem::path& library : command.plugins) note_input(library);
  for (const std::filesystem::path& scene : command.scenes) {
    FrameOptions frame = command.frame;
    frame.scene = scene;
    note_inputs(frame);
  }
  check_report(command.out_dir, kBenchFiles);
  return command.load ? run_load_bench(command) : Bench(command, arguments).run();
}

void declare_views(Options& options, BenchCommand* c) {
  declare_camera_index_option(options, c->cameras.indices, "all of them", {"0", "1,0"});
  options.integer("--holdout", "N", 1, 1'000'000, c->cameras.holdout,
                  "only the test views: every N-th by name, from the first; 3DGS uses 8. Adds the "
                  "paper's FPS, of a run over these views in each mode");
  declare_camera_path_option(options, c->cameras.path);
  declare_path_steps_option(options, c->cameras.steps);
}

void declare_measuring(Options& options, BenchCommand* c) {
  declare_plan_options(options, c->plan, "view");
  options.integer(
      "--rounds", "N", 1, 1000, c->plan.rounds,
      "measures everything N times and reports how far the medians differ (default: 1)");
  declare_mode_option(
      options, "--baseline", [c](CullMode mode) { c->baseline = mode; },
      fmt::format("mode that the ratios are relative to; also prints them per camera (default: {})",
                  kUsualBaseline));
  options.flag("--load", c->load, "measures the stages of reading the scenes instead");
  options.flag("--psnr", c->psnr,
               "adds PSNR, SSIM and FLIP against mode reference, and whether two frames are equal "
               "(seconds per view)");
  declare_exact_color_option(options, c->exact_color, "the reference of --psnr, and only that,");
  declare_occlusion_option(options, c->frame);
}

void declare_plugins(Options& options, BenchCommand* c) {
  const auto library = [](const std::string& word, const std::string& text) {
    if (word.empty()) fail(ErrorKind::usage, "--plugin: '{}' lacks the name of a library", text);
    return word;
  };
  options.list("--plugin", "LIB,..", c->plugins, library,
               "measures other renderers beside the modes: shared libraries with the functions of "
               "quadsplat/plugin.h; includes --psnr",
               {"missing.so"});
  options.integer("--plugin-timeout", "S", 1, 86400, c->plugin_timeout,
                  "seconds after which a plugin that does not answer is ended (default: 60)");
}

void declare_copies(Options& options, BenchCommand* c) {
  options.converted(
      "--replicate", "NxM", c->replicate,
      [](const auto& name, const auto& text) { return parse_size(name, text, "NxM"); },
      "renders N x M copies of each scene on a grid", {"2x1"});
  options.integer(
      "--scaling", "N", 2, 100, c->scaling,
      "measures grids of 1x1, 2x2, .. NxN copies in a view of the whole grid, and plots "
      "time against size");
}

void declare_lod(Options& options, BenchCommand* c) {
  options.flag("--lod", c->lod,
               "measures levels of detail of the first scene instead: a uniform sample, an octree, "
               "a rule of distance, and every other file, whose tree is cut if it is a .rad file");
  const auto budget = [](const std::string& word, const std::string&) {
    return parse_real("--budgets", word, 1e-6, 100);
  };
  options.list("--budgets", "P,..", c->budgets, budget,
               "of --lod: per cent of the Gaussians (default: 5,10,25,50)", {"20", "50,10"});
}

void declare_flight(Options& options, BenchCommand* c) {
  options.flag("--flight", c->flight,
               "flies along the --camera-path in real time instead, as the window draws: at its "
               "own speed, ten times as fast, and in jumps; times of frames and of cuts of levels "
               "of detail, frames with missing pages, popping, pixels behind");
}

void add_examples(Options& options) {
  options.example("quadsplat bench plush.spz --size 1600x1200 --out-dir results",
                  "all modes on every camera of a scene");
  options.example("quadsplat bench garden/ --holdout 8 --rounds 3 --out-dir results",
                  "a trained model on its test views, with the paper's FPS");
  options.example("quadsplat bench a.ply b.ply --camera-index 0,4 --cull 3dgs,quadbox --rounds 3",
                  "two modes on two views of two scenes, three times");
  options.example("quadsplat bench plush.spz --cull adr,quadbox --baseline adr --rounds 5",
                  "how many times as fast as adr quadbox is on every camera");
  options.example("quadsplat bench plush.spz --plugin ./libtheirs.so --rounds 5",
                  "another renderer beside the modes, in turns with them");
  options.example("quadsplat bench --lod plush.spz plush.rad theirs_10.ply --out-dir results",
                  "levels of detail: baselines, a tree, and a level of another tool");
  options.example("quadsplat bench city.rad --flight --camera-path path.json --budget 500000",
                  "a flight over a huge scene, whose pages are read meanwhile");
}

}  // namespace

CommandAction bench_command(Options& options) {
  const auto command = std::make_shared<BenchCommand>();
  BenchCommand* const c = command.get();
  c->frame.modes = all_modes();
  options.positionals("SCENE", c->scenes, 1, "splat files or model folders", kSceneSamples);
  declare_common_options(options, c->frame);
  declare_level_options(options, c->frame.levels);
  declare_views(options, c);
  declare_lens_options(options, c->lens);
  declare_measuring(options, c);
  declare_plugins(options, c);
  declare_copies(options, c);
  declare_lod(options, c);
  declare_flight(options, c);
  declare_shard_option(options, c->shard, "measures every N-th view, from the I-th");
  options.text("--out-dir", "DIR", c->out_dir,
               "folder of bench.csv, ratios.csv, bench.json, bench.md and plots", {"out"});
  options.overwrite();
  add_examples(options);
  return [command](Arguments arguments) {
    check_lens("bench", command->lens, command->frame);
    return run(*command, arguments);
  };
}

}  // namespace qs
