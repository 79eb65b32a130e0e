// SPDX-License-Identifier: MIT
//
// quadsplat zoom: measures the culling modes while the camera moves towards a target, and writes a
// folder that can be replayed.
#include <cstdio>
#include <memory>

#include "app/cli/camera_choice.h"
#include "app/cli/command.h"
#include "app/measure/camera_path.h"
#include "app/measure/scene_facts.h"
#include "app/report/bench_report.h"
#include "app/report/environment.h"
#include "app/report/zoom_bundle.h"
#include "app/session/alterations.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/file_hash.h"

namespace qs {
namespace {

struct ZoomCommand {
  FrameOptions frame;
  std::vector<std::filesystem::path> scenes;  // one, or none with --replay
  std::optional<int> from_camera;
  std::optional<glm::dvec3> target;
  std::optional<std::filesystem::path> out_dir, replay;
  int steps = 32;
  double closest = 0.05;
  ViewPlan plan{20, 3, 1};
};

std::optional<glm::dvec3> parse_target(const std::string& name, const std::string& text) {
  if (text == "auto") return std::nullopt;
  const std::vector<std::string> words = separated(text);
  if (words.size() != 3) fail(ErrorKind::usage, "{}: '{}' is neither X,Y,Z nor auto", name, text);
  glm::dvec3 target{0.0};
  for (int axis = 0; axis < 3; ++axis)
    target[axis] = parse_real(name, words[static_cast<std::size_t>(axis)], -1e9, 1e9);
  return target;
}

// The world position seen at the image's centre.
glm::dvec3 find_target(Session& session, const Camera& camera) {
  const auto target = find_point(*session.renderer, camera, session.settings, center_pixel(camera));
  if (!target) fail("zoom: the image's centre shows no Gaussian: name a point with --target X,Y,Z");
  return *target;
}

// Measures all steps and adds the clock of the GPU to `environment`.
std::vector<BenchRow> measure(Session& session, const ZoomBundle& bundle, ViewPlan plan,
                              nlohmann::ordered_json& environment) {
  ProgressBar bar(fmt::format("zoom {}", scene_name(session.scene->path)));
  GpuClock clock = clock_of(session);
  plan.clock = &clock;
  std::vector<BenchRow> rows = record_zoom(session, bundle, plan, bar.progress());
  add_clock(environment, clock);
  if (const std::string throttling = throttle_warning(clock.summary()); !throttling.empty())
    warn("warning: " + throttling);
  return rows;
}

void save(Session& session, const ZoomBundle& bundle, const std::filesystem::path& folder) {
  warn(save_zoom(session, bundle, folder));
  fmt::print(stderr, "wrote {}\n", folder.string());
}

int replay(const ZoomCommand& command) {
  const std::filesystem::path file = *command.replay / "zoom.json";
  if (!std::filesystem::exists(file))
    fail("zoom: {}: holds no zoom.json: name the --out-dir of a zoom", command.replay->string());
  ZoomBundle bundle = read_zoom_json(file);
  FrameOptions frame = command.frame;
  frame.scene = bundle.scene;
  frame.modes = bundle.modes;
  Session session = open_session(frame);
  session.settings = bundle.settings;
  const std::string hash = file_hash(session.scene->path);
  if (hash != bundle.scene_hash)
    fail("{}: has changed since the zoom was measured ({}, now {})", session.scene->path.string(),
         bundle.scene_hash, hash);
  nlohmann::ordered_json was = bundle.altered, is = alterations_of(session).json;
  if (was["edits"] != is["edits"])
    fail(ErrorKind::usage, "zoom: {}: its scene was edited, and these edits cannot be repeated",
         command.replay->string());
  nlohmann::ordered_json environment = environment_json(session);
  std::vector<BenchRow> rows =
      measure(session, bundle, command.out_dir ? command.plan : ViewPlan{1, 0, 1}, environment);
  const std::vector<std::string> differences = count_differences(bundle.rows, rows);
  fmt::print("{} steps, {} modes: {}\n", bundle.steps, bundle.modes.size(),
             differences.empty() ? "all pair counts are equal"
                                 : fmt::format("{} counts differ", differences.size()));
  for (const std::string& sentence : differences) warn(sentence);
  if (command.out_dir) {
    bundle.rows = std::move(rows);
    bundle.environment = std::move(environment);
    save(session, bundle, *command.out_dir);
  }
  return differences.empty() ? kExitOk : kExitComparison;
}

int run(ZoomCommand& command, Arguments arguments) {
  if (command.scenes.size() != (command.replay ? 0u : 1u))
    fail(ErrorKind::usage, "zoom: give either one SCENE or --replay DIR");
  if (command.replay) {
    require_folder("zoom", *command.replay);
    note_input(*command.replay / "zoom.json");
  } else {
    command.frame.scene = command.scenes.front();
    note_inputs(command.frame);
  }
  check_report(command.out_dir, kZoomFiles);
  if (command.replay) return replay(command);
  Session session = open_session(command.frame);
  CameraChoice choice;
  if (command.from_camera) choice.indices = {*command.from_camera};
  const Camera start = choose_shots(choice, command.frame, session).front().camera;
  ZoomBundle bundle =
      start_zoom(session, start, command.target ? *command.target : find_target(session, start));
  bundle.steps = command.steps;
  bundle.closest = command.closest;
  bundle.modes = command.frame.modes;
  bundle.environment["flags"] = std::vector<std::string>(arguments.begin(), arguments.end());
  bundle.rows = measure(session, bundle, command.plan, bundle.environment);
  if (command.out_dir) {
    save(session, bundle, *command.out_dir);
  } else {
    fmt::print("{}", format_csv(bundle.rows));
  }
  return kExitOk;
}

}  // namespace

CommandAction zoom_command(Options& options) {
  const auto command = std::make_shared<ZoomCommand>();
  command->frame.modes = all_modes();
  options.positionals("SCENE", command->scenes, 0, kSceneHelp, kSceneSamples);
  declare_common_options(options, command->frame);
  options.integer("--from-camera", "N", 0, 1'000'000'000, command->from_camera,
                  "camera of the cameras file to start from (default: 0, or a view that frames the "
                  "scene)");
  options.converted("--target", "X,Y,Z|auto", command->target, parse_target,
                    "point to approach (default: auto, the one seen at the image's centre)",
                    {"auto", "0.1,0,4"});
  options.integer("--steps", "N", 2, 100000, command->steps, "views along the way (default: 32)");
  options.real("--closest", "X", 1e-4, 0.999, command->closest,
               "last distance to the target divided by the first (default: 0.05)");
  declare_plan_options(options, command->plan, "step");
  options.text("--out-dir", "DIR", command->out_dir,
               "folder of zoom.csv, zoom.json, plots, and pictures of the first, middle and last "
               "step",
               {"out"});
  options.overwrite();
  options.text("--replay", "DIR", command->replay,
               "renders the zoom stored in DIR again; ends with exit code 4 if counts differ",
               {"zoom"});
  options.example("quadsplat zoom plush.spz --from-camera 0 --out-dir zoom",
                  "curves of all modes towards the point that camera 0 looks at");
  options.example("quadsplat zoom --replay zoom", "the same counts on another machine?");
  return [command](Arguments arguments) { return run(*command, arguments); };
}

}  // namespace qs
