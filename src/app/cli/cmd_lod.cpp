// SPDX-License-Identifier: MIT
//
// quadsplat lod: scenes -> a .rad file with levels of detail, or a streamed SOG.
#include <cstdio>
#include <memory>
#include <system_error>

#include <fmt/format.h>

#include "app/cli/command.h"
#include "app/cli/shared_options.h"
#include "base/fail.h"
#include "base/path_kind.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "base/warn.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/scene/reader.h"
#include "learn/lod/build.h"
#include "learn/lod/streamed_levels.h"
#include "raster/scene/place.h"

namespace qs {
namespace {

constexpr std::uint64_t kLeastMemory = 64'000'000;

struct LodCommand {
  std::filesystem::path input;
  std::vector<std::filesystem::path> others;  // inputs, then the output
  std::uint64_t memory = 0;
  std::string axes;
  bool original = false;
};

int run(const LodCommand& command) {
  const std::filesystem::path output = command.others.back();
  const bool is_tree = lower_case(output.extension().string()) == ".rad";
  const bool is_file = output.filename() == "lod-meta.json";
  if (!is_tree && !is_file && !output.extension().empty())
    fail(ErrorKind::usage, "lod: {}: only .rad files and folders of streamed SOG can be written",
         output.string());
  if (command.original && !is_tree)
    fail(ErrorKind::usage, "lod: --original: {}: only .rad files keep the original values",
         output.string());
  const std::filesystem::path folder =
      is_file || !output.has_filename() ? absolute(output).parent_path() : output;
  const std::filesystem::path work = folder.string() + ".unfinished";
  LodBuild build;
  build.inputs = {command.input};
  build.inputs.insert(build.inputs.end(), command.others.begin(), command.others.end() - 1);
  build.output = is_tree ? output : work / "tree.rad";
  build.memory = command.memory;
  build.axes = command.axes;
  build.original = command.original;
  build.warn = [](const std::string& sentence) { warn(sentence); };
  for (const std::filesystem::path& input : build.inputs) note_input(find_scene_file(input));
  note_own(work);
  if (is_tree) {
    check_targets({output});
  } else {
    check_folder(folder);
    if (is_folder(folder)) check_targets({folder / "lod-meta.json"});
    make_folder(work);
  }
  ThreadPool pool(0);
  ProgressBar bar("building levels of detail");
  build.progress = is_tree ? bar.progress() : part_of(bar.progress(), 0, 0.4f);
  const LodReport report = build_lod(build, pool);
  if (!is_tree && report.origin != glm::dvec3(0))
    warn(fmt::format("{}: its positions count from {}, because the format has no doubles",
                     output.string(), format_origin(report.origin)));
  if (!is_tree) write_streamed_levels(build.output, folder, pool, part_of(bar.progress(), 0.4f, 1));
  bar.hide();
  std::error_code error;
  const auto bytes = std::filesystem::file_size(build.output, error);
  if (!is_tree) std::filesystem::remove_all(work, error);
  fmt::print(stderr, "wrote {} ({} leaves, {}, SH degree {}{})\n", output.string(),
             grouped(report.leaves),
             is_tree ? grouped(report.nodes) + " nodes" : counted(kStreamedLevels, "level"),
             report.sh_degree,
             !is_tree ? ""
             : error  ? ", size unknown"
                      : ", " + bytes_text(bytes));
  return kExitOk;
}

}  // namespace

CommandAction lod_command(Options& options) {
  const auto command = std::make_shared<LodCommand>();
  options.positional("IN", command->input, kSceneHelp, kSceneSamples);
  options.positionals(
      "OUT", command->others, 1,
      "further scenes, and at last the .rad file to write, or the folder of a streamed SOG",
      {"out.rad", "out.ply"});
  options.converted("--memory", "SIZE", command->memory,
                    [](const std::string& option, const std::string& words) {
                      const std::uint64_t bytes = parse_bytes(option, words);
                      if (bytes < kLeastMemory)
                        fail(ErrorKind::usage, "{}: '{}' is less than 64 MB", option, words);
                      return bytes;
                    },
                    "memory for the parts that are built at a time, such as 512M; scenes that are "
                    "no binary .ply or instances must fit beside it (default: 4G, or more for many "
                    "threads)",
                    {"64M", "2G"});
  options.flag("--original", command->original,
               "also keeps the leaves as the scenes have them, bit for bit and in their order; "
               "without it a .rad file rounds all but their centres");
  declare_axes_option(options, command->axes);
  options.overwrite();
  options.example("quadsplat lod city.ply city.rad", "a tree that quadsplat and Spark open");
  options.example("quadsplat lod tiles/*.ply city.rad --memory 1G",
                  "one tree of many scenes, on a small machine");
  options.example("quadsplat lod city.ply city_sog", "five levels as a streamed SOG");
  return [command](Arguments) { return run(*command); };
}

}  // namespace qs
