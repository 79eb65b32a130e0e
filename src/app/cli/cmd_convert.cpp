// SPDX-License-Identifier: MIT
//
// quadsplat convert: a scene in another format, with fewer SH degrees or fewer Gaussians.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/cli/command.h"
#include "app/cli/frame_options.h"
#include "app/session/progress_bar.h"
#include "io/scene/cloud_order.h"
#include "io/scene/sh_degree.h"
#include "io/scene/writer.h"

namespace qs {
namespace {

struct ConvertCommand {
  std::filesystem::path input, output;
  std::string axes, format;
  int degree = kMaxShDegree, largest = 0;
};

// The different values of a column of the table of writers.
std::vector<std::string> written(const char* WriterRow::*column) {
  std::vector<std::string> words;
  for (const WriterRow& row : writers()) {
    if (std::find(words.begin(), words.end(), row.*column) == words.end())
      words.emplace_back(row.*column);
  }
  return words;
}

int run(const ConvertCommand& command) {
  ThreadPool pool(0);
  Scene scene = load_scene(command.input, pool, -1, command.axes);
  scene.cloud = with_sh_degree(std::move(scene.cloud), command.degree);
  if (command.largest > 0) {
    scene.cloud = keep_largest(std::move(scene.cloud), static_cast<std::size_t>(command.largest));
  }
  const WriterRow& format = [&]() -> const WriterRow& {
    ProgressBar bar("writing");
    return write_scene(scene.cloud, command.output, pool, bar.progress(), command.format);
  }();
  std::error_code error;
  const auto bytes = std::filesystem::file_size(command.output, error);
  fmt::print(stderr, "wrote {} ({} Gaussians, SH degree {}, {})\n", command.output.string(),
             grouped(scene.cloud.size()), std::min(scene.cloud.sh_degree, format.max_sh_degree),
             error ? "size unknown" : bytes_text(bytes));
  return kExitOk;
}

}  // namespace

Action convert_command(Options& options) {
  const auto command = std::make_shared<ConvertCommand>();
  const std::vector<std::string> endings = written(&WriterRow::extension);
  const std::vector<std::string> formats = written(&WriterRow::name);
  Options::Samples outputs = {"out.unknown"};
  for (const std::string& ending : endings) outputs.push_back("out" + ending);
  options.positional("IN", command->input, "splat file or model folder", kSceneSamples);
  options.positional("OUT", command->output,
                     "file to write; its ending chooses the format: " + joined(endings, ", "),
                     outputs);
  options.integer("--sh-degree", "N", 0, kMaxShDegree, command->degree,
                  "highest degree of view-dependent colour to keep (default: all)");
  options.integer("--keep-largest", "N", 1, 2'000'000'000, command->largest,
                  "keeps the N Gaussians with the largest opacity times area (default: all)");
  options.text("--format", "NAME", command->format,
               "one of " + joined(formats, ", ") + " (default: by the ending)", formats);
  declare_axes_option(options, command->axes);
  options.example("quadsplat convert plush.spz plush.ply", "a file that every viewer reads");
  options.example("quadsplat convert garden/ small.spz --keep-largest 300000 --sh-degree 1",
                  "a small file of a large model");
  return [command](Arguments) { return run(*command); };
}

}  // namespace qs
