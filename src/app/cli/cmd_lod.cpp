// SPDX-License-Identifier: MIT
//
// quadsplat lod: scenes -> a .rad file with levels of detail.
#include <cstdio>
#include <memory>
#include <system_error>

#include <fmt/format.h>

#include "app/cli/command.h"
#include "app/cli/shared_options.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "base/warn.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/scene/reader.h"
#include "learn/lod/build.h"

namespace qs {
namespace {

constexpr std::uint64_t kLeastMemory = 64'000'000;

struct LodCommand {
  std::filesystem::path input;
  std::vector<std::filesystem::path> others;  // inputs, then the output
  std::uint64_t memory = 4'000'000'000;
  std::string axes;
};

int run(const LodCommand& command) {
  LodBuild build;
  build.inputs = {command.input};
  build.inputs.insert(build.inputs.end(), command.others.begin(), command.others.end() - 1);
  build.output = command.others.back();
  build.memory = command.memory;
  build.axes = command.axes;
  build.warn = [](const std::string& sentence) { warn(sentence); };
  if (lower_case(build.output.extension().string()) != ".rad")
    fail(ErrorKind::usage, "lod: {}: only .rad files can be written", build.output.string());
  for (const std::filesystem::path& input : build.inputs) note_input(find_scene_file(input));
  check_targets({build.output});
  note_own(build.output.string() + ".unfinished");
  ThreadPool pool(0);
  ProgressBar bar("building levels of detail");
  build.progress = bar.progress();
  const LodReport report = build_lod(build, pool);
  bar.hide();
  std::error_code error;
  const auto bytes = std::filesystem::file_size(build.output, error);
  fmt::print(stderr, "wrote {} ({} leaves, {} nodes, SH degree {}, {})\n", build.output.string(),
             grouped(report.leaves), grouped(report.nodes), report.sh_degree,
             error ? "size unknown" : bytes_text(bytes));
  return kExitOk;
}

}  // namespace

CommandAction lod_command(Options& options) {
  const auto command = std::make_shared<LodCommand>();
  options.positional("IN", command->input, kSceneHelp, kSceneSamples);
  options.positionals("OUT", command->others, 1,
                      "further scenes, and at last the .rad file to write", {"out.rad", "out.ply"});
  options.converted("--memory", "SIZE", command->memory,
                    [](const std::string& option, const std::string& words) {
                      const std::uint64_t bytes = parse_bytes(option, words);
                      if (bytes < kLeastMemory)
                        fail(ErrorKind::usage, "{}: '{}' is less than 64 MB", option, words);
                      return bytes;
                    },
                    "memory for the parts that are built at a time, such as 512M; scenes that are "
                    "no binary .ply must fit beside it (default: 4G)",
                    {"64M", "2G"});
  declare_axes_option(options, command->axes);
  options.overwrite();
  options.example("quadsplat lod city.ply city.rad", "a tree that quadsplat and Spark open");
  options.example("quadsplat lod tiles/*.ply city.rad --memory 1G",
                  "one tree of many scenes, on a small machine");
  return [command](Arguments) { return run(*command); };
}

}  // namespace qs
