// SPDX-License-Identifier: MIT
//
// quadsplat info: facts of scene files, as text or JSON.
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/cli/shared_options.h"
#include "app/report/scene_report.h"
#include "base/error.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/json_text.h"
#include "io/bytes/replace_file.h"
#include "io/camera/cameras.h"
#include "io/camera/photographs.h"

namespace qs {
namespace {

struct InfoCommand {
  std::vector<std::filesystem::path> files;
  std::string axes;
  std::optional<std::filesystem::path> json;
};

// Their lenses, or the reason why they cannot be read: `info` is about the scene.
std::string cameras_beside(const Scene& scene) {
  const auto file = find_cameras_file(scene.path);
  try {
    return file ? cameras_sentence(read_camera_set(*file)) : "";
  } catch (const Error& error) {
    return error.what();
  }
}

int run(const InfoCommand& command) {
  if (command.json) {
    for (const std::filesystem::path& file : command.files) note_input(find_scene_file(file));
    check_targets({command.json});
  }
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  ThreadPool pool(0);
  for (const std::filesystem::path& file : command.files) {
    const Scene scene = load_scene(file, pool, -1, command.axes);
    SceneReport report = make_report(scene.cloud);
    report.cameras = cameras_beside(scene);
    if (command.json) list.push_back(report_json(scene, report));
    if (command.json != "-") fmt::print("{}", report_text(scene, report));
  }
  if (command.json) write_text(*command.json, json_file_text(list));
  return kExitOk;
}

}  // namespace

CommandAction info_command(Options& options) {
  const auto command = std::make_shared<InfoCommand>();
  options.positionals("FILE", command->files, 1, "splat files or model folders", kSceneSamples);
  declare_axes_option(options, command->axes);
  options.text("--json", "FILE", command->json,
               "a JSON list with one object per file; - = stdout, instead of the text",
               {"-", "info.json"});
  options.overwrite();
  options.example("quadsplat info garden/ plush.spz",
                  "format, size, extents and value ranges of two scenes");
  return [command](Arguments) { return run(*command); };
}

}  // namespace qs
