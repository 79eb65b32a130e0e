// SPDX-License-Identifier: MIT
//
// quadsplat conformance: scenes that test renderers, and a diagnosis of a renderer's pictures.
#include <cstdio>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/cli/command.h"
#include "app/cli/shared_options.h"
#include "app/conformance/judge.h"
#include "app/conformance/kit_scenes.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "io/bytes/replace_file.h"

namespace qs {
namespace {

struct ConformanceCommand {
  std::optional<std::filesystem::path> out_dir, judged, report, json;
};

std::string folder_name(const std::filesystem::path& folder) {
  const std::filesystem::path path = std::filesystem::absolute(folder).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

int judge_folder(const ConformanceCommand& command, ThreadPool& pool) {
  const Submission submission = read_submission(*command.judged);
  KitVerdict judgement = judge_kit(submission, Variants(0, pool), pool);
  if (judgement.count(Result::failed) != 0) {
    ProgressBar bar("drawing with mistakes");
    judgement = judge_kit(submission, Variants(2, pool, bar.progress()), pool);
  }
  if (command.json != "-") fmt::print("{}", format_verdict(judgement));
  if (command.json) write_text(*command.json, verdict_json(judgement));
  if (command.report) {
    write_text(*command.report, verdict_page(judgement, submission, folder_name(*command.judged)));
    fmt::print(stderr, "wrote {}\n", command.report->string());
  }
  return judgement.count(Result::failed) == 0 ? kExitOk : kExitComparison;
}

int run(const ConformanceCommand& command) {
  check_rules(
      "conformance",
      {{(command.report || command.json) && !command.judged, "--report and --json need --judge"},
       {!command.out_dir && !command.judged, "nothing to do: give --out-dir or --judge"}});
  check_targets({command.report, command.json});
  if (command.judged && !command.out_dir) require_folder("conformance", *command.judged);
  ThreadPool pool(0);
  if (command.out_dir) {
    {
      ProgressBar bar("drawing the scenes");
      write_kit(*command.out_dir, pool, bar.progress());
    }
    fmt::print(stderr, "wrote {} scenes to {}\n", kit_scenes().size(), command.out_dir->string());
  }
  return command.judged ? judge_folder(command, pool) : int{kExitOk};
}

}  // namespace

CommandAction conformance_command(Options& options) {
  const auto command = std::make_shared<ConformanceCommand>();
  options.text("--out-dir", "DIR", command->out_dir,
               "writes the scenes as .ply with cameras and images in double precision", {"kit"});
  options.overwrite();
  options.text("--judge", "DIR", command->judged,
               "judges the pictures NAME.png of the scenes in this folder and names the likely "
               "cause of what fails; exit code 4 if a scene fails",
               {"kit/truth", "missing"});
  options.text("--report", "FILE.html", command->report, "the judgement as a page with pictures",
               {"judged.html"});
  options.text("--json", "FILE", command->json, "the judgement as JSON; - = stdout",
               {"-", "judged.json"});
  options.example("quadsplat conformance --out-dir kit", "the scenes, to be drawn by any renderer");
  options.example("quadsplat conformance --judge pictures --report judged.html",
                  "is the renderer correct, and if not, why?");
  return [command](Arguments) { return run(*command); };
}

}  // namespace qs
