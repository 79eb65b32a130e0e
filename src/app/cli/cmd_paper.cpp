// SPDX-License-Identifier: MIT
//
// quadsplat paper: data sets -> trained models and the paper's tables. The command checks its
// options and hands them as JSON to workflows/paper/run.py, which plans the work and starts
// Snakemake.
#include <chrono>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/cli/command.h"
#include "app/cli/shared_options.h"
#include "app/measure/measure_view.h"
#include "app/measure/shard.h"
#include "base/assets.h"
#include "base/child_process.h"
#include "base/fail.h"
#include "base/json_of.h"
#include "base/quit_signals.h"
#include "io/bytes/json_text.h"
#include "raster/api/renderer.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

constexpr int kNotFound = 127;  // the exit code of a program that was not found

struct PaperCommand {
  std::filesystem::path root, out_dir;
  std::vector<std::string> scenes, rows;
  std::optional<std::filesystem::path> methods, lpips;
  std::optional<std::string> train_options;
  std::string profile = "local";
  Pipeline pipeline = Pipeline::classic;
  std::optional<Backend> backend;
  int seeds = 1, iterations = 30'000;
  ViewPlan plan{100, 20, 3};
  std::optional<int> jobs, resolution_scale;
  Shard shard;
  bool yes = false, partial = false;
};

ordered_json path_or_null(const std::optional<std::filesystem::path>& path) {
  return path ? ordered_json(std::filesystem::absolute(*path).string()) : ordered_json();
}

ordered_json request_of(const PaperCommand& c) {
  return {{"program", (program_folder() / "quadsplat").string()},
          {"root", std::filesystem::absolute(c.root).string()},
          {"out_dir", std::filesystem::absolute(c.out_dir).string()},
          {"scenes", c.scenes},
          {"rows", c.rows},
          {"methods", path_or_null(c.methods)},
          {"lpips", path_or_null(c.lpips)},
          {"train_options", c.train_options.value_or("")},
          {"profile", c.profile},
          {"pipeline", kPipelineNames[static_cast<int>(c.pipeline)]},
          {"backend", c.backend ? kBackendNames[static_cast<int>(*c.backend)] : "auto"},
          {"seeds", c.seeds},
          {"iterations", c.iterations},
          {"frames", c.plan.frames},
          {"warmup", c.plan.warmup},
          {"rounds", c.plan.rounds},
          {"jobs", json_of(c.jobs)},
          {"resolution_scale", json_of(c.resolution_scale)},
          {"shard", {c.shard.index, c.shard.count}},
          {"yes", c.yes},
          {"partial", c.partial}};
}

// Ends with the exit code of the script, which prints its own sentences.
int run(const PaperCommand& command) {
  require_folder("paper", command.root);
  const auto script = find_asset("workflows/paper/run.py");
  if (!script)
    fail("paper: the folder workflows/paper is not beside the program: install it again");
  QuitSignals signals;
  ChildEnd end;
  try {
    ChildProcess child({.words = {"python3", script->string(), json_line(request_of(command))},
                        .inherits = {{STDIN_FILENO, STDIN_FILENO},
                                     {STDOUT_FILENO, STDOUT_FILENO},
                                     {STDERR_FILENO, STDERR_FILENO}}});
    bool asked = false;
    std::optional<ChildEnd> ended;
    while (!(ended = child.wait_for(std::chrono::milliseconds(100)))) {
      if (QuitSignals::arrived() && !asked) child.terminate();
      asked = QuitSignals::arrived();
    }
    end = *ended;
  } catch (const Error&) {
    end.exit_code = kNotFound;
  }
  if (end.exit_code == kNotFound)
    fail(ErrorKind::device,
         "paper: python3 was not found: install the packages python3 and snakemake");
  if (end.exit_code == kExitInterrupted) throw Cancelled{};
  if (end.signal != 0) fail(ErrorKind::device, "paper: the workflow ended by {}", end.text());
  return end.exit_code;
}

void declare_names(Options& options, const std::string& name, std::vector<std::string>& names,
                   const std::string& help, const Options::Samples& samples) {
  const auto checked = [name](const std::string& word, const std::string& text) {
    if (word.empty()) fail(ErrorKind::usage, "{}: '{}' lacks a name", name, text);
    return word;
  };
  options.list(name, "NAME,..", names, checked, help, samples);
}

void declare_training(Options& options, PaperCommand& c) {
  options.integer("--iterations", "N", 1, 10'000'000, c.iterations,
                  "of every training (default: 30000)");
  options.integer("--resolution-scale", "N", 1, 64, c.resolution_scale,
                  "trains and measures at 1/N of the photographs' size (default: as train)");
  options.text("--train-options", "WORDS", c.train_options,
               "further options of every training, such as '--sh-degree 2'", {"--sh-degree 2"});
  declare_backend_option(options, c.backend, "the backend of all runs");
}

void declare_measuring(Options& options, PaperCommand& c) {
  options.enumerated("--pipeline", kPipelineNames, c.pipeline,
                     "pipeline of the measured frames (default: classic, as in the paper)");
  declare_plan_options(options, c.plan, "view");
  options.integer("--rounds", "N", 1, 1000, c.plan.rounds, "of every measurement (default: 3)");
  options.text("--lpips", "FILE", c.lpips,
               "weights of LPIPS, see eval --lpips: adds LPIPS to the tables", {"missing"});
}

void declare_work(Options& options, PaperCommand& c) {
  options.text("--profile", "NAME", c.profile,
               "local, slurm, or the folder of a Snakemake profile (default: local)", {"local"});
  options.integer("--jobs", "N", 1, 10000, c.jobs,
                  "jobs at the same time (default: one per GPU; slurm: as its profile says)");
  options.converted("--shard", "I/N", c.shard, parse_shard,
                    "does every N-th training with its measurements, from the I-th, and writes no "
                    "tables",
                    {"1/2"});
  options.flag("--yes", c.yes, "starts without asking");
  options.flag("--partial", c.partial,
               "runs nothing: writes the tables of the results that are finished");
}

}  // namespace

CommandAction paper_command(Options& options) {
  const auto command = std::make_shared<PaperCommand>();
  PaperCommand& c = *command;
  options.positional("ROOT", c.root,
                     "folder with data sets: those of the paper, and any COLMAP folders", {"."});
  options.text("--out-dir", "DIR", c.out_dir,
               "folder of models, results and tables; the same line continues", {"out"});
  options.required();
  declare_names(options, "--scenes", c.scenes, "only these scenes (default: all found)",
                {"images"});
  declare_names(options, "--rows", c.rows,
                "rows of the tables: 3dgs, adr, dualbox, quadbox-naive, quadbox, dash, "
                "dash+quadbox, mask, mask+quadbox; all; or published: all, and adr trained with "
                "its own rules (default: all)",
                {"3dgs,quadbox", "published"});
  options.integer("--seeds", "N", 1, 1000, c.seeds, "trainings of each row and scene (default: 1)");
  options.text("--methods", "FILE", c.methods,
               "JSON file with methods of your own, a row each: docs/workflow.md", {"missing"});
  declare_training(options, c);
  declare_measuring(options, c);
  declare_work(options, c);
  options.example("quadsplat paper ~/data --out-dir tables", "the paper's tables on one machine");
  options.example("quadsplat paper ~/data --out-dir tables --seeds 3 --profile slurm",
                  "the same on a cluster, with three seeds");
  return [command](Arguments) { return run(*command); };
}

}  // namespace qs
