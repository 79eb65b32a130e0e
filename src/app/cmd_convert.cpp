// SPDX-License-Identifier: MIT
#include <cstdio>
#include <system_error>
#include <utility>

#include "app/command.h"
#include "app/frame_options.h"
#include "app/progress_bar.h"
#include "io/sh_degree.h"
#include "io/writer.h"
#include "raster/scene/fail.h"

namespace qs {
namespace {

std::string writable_formats() {
  std::vector<std::string> endings;
  for (const WriterRow& row : writers()) endings.emplace_back(row.extension);
  return joined(endings, ", ");
}

}  // namespace

int run_convert(Arguments arguments) {
  std::filesystem::path input, output;
  int degree = kMaxShDegree;
  Options options("convert", "writes a scene in another format");
  options.positional("IN", input, "splat file or model folder");
  options.positional("OUT", output, "its ending tells the format: " + writable_formats());
  options.integer("--sh-degree", "N", 0, kMaxShDegree, degree,
                  "highest degree of view-dependent colour to keep");
  options.example("quadsplat convert plush.spz plush.ply", "a file that every viewer reads");
  if (!options.parse(arguments)) return kExitOk;

  Scene scene = load_scene(input);
  scene.cloud = with_sh_degree(std::move(scene.cloud), degree);
  {
    ProgressBar bar("writing");
    write_scene(scene.cloud, output, bar.progress());
  }
  std::error_code error;
  const auto bytes = std::filesystem::file_size(output, error);
  fmt::print(stderr, "wrote {} ({} Gaussians, SH degree {}, {})\n", output.string(),
             grouped(scene.cloud.size()), scene.cloud.sh_degree,
             error ? "size unknown" : bytes_text(bytes));
  return kExitOk;
}

}  // namespace qs
