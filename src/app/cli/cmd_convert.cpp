// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdio>
#include <system_error>
#include <utility>

#include "app/cli/command.h"
#include "app/cli/frame_options.h"
#include "app/session/progress_bar.h"
#include "io/scene/cloud_order.h"
#include "io/scene/sh_degree.h"
#include "io/scene/writer.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

std::string writable_formats() {
  std::vector<std::string> endings;
  for (const WriterRow& row : writers()) {
    if (std::find(endings.begin(), endings.end(), row.extension) == endings.end()) {
      endings.emplace_back(row.extension);
    }
  }
  return joined(endings, ", ");
}

std::string format_names() {
  std::vector<std::string> names;
  for (const WriterRow& row : writers()) names.emplace_back(row.name);
  return joined(names, ", ");
}

}  // namespace

int run_convert(Arguments arguments) {
  std::filesystem::path input, output;
  std::string axes, format;
  int degree = kMaxShDegree, largest = 0;
  Options options("convert", "writes a scene in another format");
  options.positional("IN", input, "splat file or model folder");
  options.positional("OUT", output, "its ending tells the format: " + writable_formats());
  options.integer("--sh-degree", "N", 0, kMaxShDegree, degree,
                  "highest degree of view-dependent colour to keep");
  options.integer("--keep-largest", "N", 1, 2'000'000'000, largest,
                  "keeps the N Gaussians that cover most: opacity times area");
  options.value("--format", "NAME", "one of " + format_names() + " (default: by the ending)",
                [&format](const std::string& text) { format = text; });
  declare_axes_option(options, axes);
  options.example("quadsplat convert plush.spz plush.ply", "a file that every viewer reads");
  options.example("quadsplat convert garden/ small.spz --keep-largest 300000 --sh-degree 1",
                  "a small file of a large model");
  if (!options.parse(arguments)) return kExitOk;

  ThreadPool pool;
  Scene scene = load_scene(input, pool, -1, axes);
  scene.cloud = with_sh_degree(std::move(scene.cloud), degree);
  if (largest > 0) {
    scene.cloud = keep_largest(std::move(scene.cloud), static_cast<std::size_t>(largest));
  }
  const WriterRow& written = [&]() -> const WriterRow& {
    ProgressBar bar("writing");
    return write_scene(scene.cloud, output, pool, bar.progress(), format);
  }();
  std::error_code error;
  const auto bytes = std::filesystem::file_size(output, error);
  fmt::print(stderr, "wrote {} ({} Gaussians, SH degree {}, {})\n", output.string(),
             grouped(scene.cloud.size()), std::min(scene.cloud.sh_degree, written.max_sh_degree),
             error ? "size unknown" : bytes_text(bytes));
  return kExitOk;
}

}  // namespace qs
