// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/cli/frame_options.h"
#include "app/report/scene_report.h"

namespace qs {

int run_info(Arguments arguments) {
  std::vector<std::filesystem::path> files;
  bool json = false;
  Options options("info", "tells what is in scene files");
  options.positionals("FILE", files, "splat files or model folders");
  std::string axes;
  declare_axes_option(options, axes);
  options.flag("--json", json, "a JSON list with one object per file");
  options.example("quadsplat info garden/ plush.spz",
                  "format, size, extents and ranges of two scenes");
  if (!options.parse(arguments)) return kExitOk;

  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  ThreadPool pool;
  for (const std::filesystem::path& file : files) {
    const Scene scene = load_scene(file, pool, -1, axes);
    const SceneReport report = make_report(scene.cloud);
    if (json) {
      list.push_back(report_json(scene, report));
    } else {
      fmt::print("{}", report_text(scene, report));
    }
  }
  if (json) {
    fmt::print("{}\n", list.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  }
  return kExitOk;
}

}  // namespace qs
