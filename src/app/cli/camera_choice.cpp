// SPDX-License-Identifier: MIT
#include "app/cli/camera_choice.h"

#include <algorithm>
#include <system_error>

#include "app/framing/first_view.h"
#include "app/framing/scene_box.h"
#include "app/framing/up_axis.h"
#include "app/measure/camera_path.h"
#include "app/session/placed_cameras.h"
#include "base/fail.h"
#include "base/path_kind.h"
#include "io/camera/cameras.h"
#include "io/cloud/axes.h"

namespace qs {
namespace {

constexpr glm::ivec2 kFramingSize{1280, 720};

Shot numbered_shot(const std::vector<Camera>& cameras, int index) {
  const Camera& camera = cameras[static_cast<std::size_t>(index)];
  return {camera, index,
          fmt::format("camera {}{}", index, camera.name.empty() ? "" : " (" + camera.name + ")")};
}

std::vector<Shot> all_shots(const std::vector<Camera>& cameras) {
  std::vector<Shot> shots;
  for (int i = 0; i < static_cast<int>(cameras.size()); ++i)
    shots.push_back(numbered_shot(cameras, i));
  return shots;
}

// Every N-th camera by name. The shots keep the numbers of the cameras in the file.
std::vector<Shot> test_shots(const std::vector<Camera>& cameras, int holdout) {
  std::vector<Shot> shots = all_shots(cameras);
  std::ranges::stable_sort(shots, {}, [](const Shot& shot) { return shot.camera.name; });
  std::vector<Shot> test;
  for (std::size_t i = 0; i < shots.size(); i += static_cast<std::size_t>(holdout))
    test.push_back(shots[i]);
  return test;
}

// `count` views at equal time steps, from the first keyframe to the last.
std::vector<Shot> path_shots(const std::filesystem::path& file, int count) {
  std::vector<Shot> shots;
  for (const Camera& camera : sample_path(read_camera_path(file), count)) {
    const auto number = static_cast<int>(shots.size());
    shots.push_back({camera, number, fmt::format("path {:04}", number)});
  }
  return shots;
}

// Throws Error(usage) for the name of a file.
void require_json_text(const std::string& given) {
  if (given.starts_with('{') || !is_there(given)) return;
  fail(ErrorKind::usage,
       "--camera-json: {} is a file: give the text of one camera here, or the file to --cameras",
       given);
}

std::vector<Shot> unsized_shots(const CameraChoice& choice, const FrameOptions& frame,
                                const Session& session) {
  const Scene& scene = *session.scene;
  if (choice.json) require_json_text(*choice.json);
  if (choice.json) return {{parse_camera(*choice.json, "--camera-json"), -1, "--camera-json"}};
  if (choice.path) return path_shots(*choice.path, choice.steps.value_or(kPathSteps));
  const auto file = cameras_file(frame, scene.path);
  const std::vector<Camera> cameras = cameras_of(frame, scene);
  const bool chosen = !choice.indices.empty() || choice.all || choice.holdout > 0;
  if (!cameras.empty()) {
    const int count = static_cast<int>(cameras.size());
    if (choice.all) return all_shots(cameras);
    if (choice.holdout > 0) return test_shots(cameras, choice.holdout);
    if (choice.usually_all && choice.indices.empty()) return all_shots(cameras);
    std::vector<Shot> shots;
    for (const int index : choice.indices.empty() ? std::vector<int>{0} : choice.indices) {
      if (index >= count)
        fail("{}: has no camera {}: it holds cameras 0 to {}", file->string(), index, count - 1);
      shots.push_back(numbered_shot(cameras, index));
    }
    return shots;
  }
  if (chosen && file)
    fail(
        "{}: none of its cameras sees a Gaussian; name it with --cameras to draw them all the same",
        file->string());
  if (chosen)
    fail(
        "{}: no cameras were found beside it or in the three folders above: name their file with "
        "--cameras",
        scene.path.string());
  const Framing framing =
      choose_framing(scene.cloud, declared_up(frame.up, scene.vertical_axis), *session.pool);
  if (framing.upside_down)
    warn(fmt::format("{} seems to be upside down: try --axes {}", scene.path.filename().string(),
                     turned_over(scene.axes)));
  const glm::ivec2 size = frame.size.value_or(kFramingSize);
  return {{framed_camera(framing, size.x, size.y), -1, "framing"}};
}

}  // namespace

std::vector<Camera> cameras_of(const FrameOptions& frame, const Scene& scene) {
  const auto file = cameras_file(frame, scene.path);
  if (!file) return {};
  const auto [cameras, warnings] = placed_cameras(*file, scene, frame.cameras.has_value());
  for (const std::string& sentence : warnings) warn(sentence);
  if (cameras.empty() && (frame.cameras || warnings.empty()))
    fail("{}: holds no camera", file->string());
  return cameras;
}

Shot overview_shot(const FrameOptions& frame, const Scene& scene) {
  const glm::ivec2 size = frame.size.value_or(kFramingSize);
  const glm::dvec3 up = declared_up(frame.up, scene.vertical_axis).value_or(world_up(""));
  return {frame_cloud(scene.cloud, up, size.x, size.y), -1, "framing"};
}

void declare_camera_index_option(Options& options, std::vector<int>& indices,
                                 const std::string& usual, const Options::Samples& samples) {
  const auto index = [](const std::string& word, const std::string&) {
    return parse_integer("--camera-index", word, 0, 1'000'000'000);
  };
  options.list("--camera-index", "N,..", indices, index,
               fmt::format("cameras of the cameras file, counted from 0 (default: {})", usual),
               samples);
}

void declare_path_steps_option(Options& options, std::optional<int>& steps) {
  options.integer(
      "--path-steps", "N", 1, 1'000'000, steps,
      fmt::format("views along --camera-path, at equal time steps (default: {})", kPathSteps));
}

void declare_camera_choice(Options& options, CameraChoice& choice) {
  declare_camera_index_option(options, choice.indices, "0", {"0", "1"});
  options.text("--camera-json", "JSON", choice.json, "one camera in the layout of cameras.json",
               {"{}", format_camera(look_at({0, 0, -2}, {0, 0, 1}, {0, -1, 0}, 1, 40, 24))});
  options.flag("--all-cameras", choice.all,
               "every camera of the file; its number and name are inserted into file names");
  declare_camera_path_option(options, choice.path);
  declare_path_steps_option(options, choice.steps);
}

void require_one_picture(const char* command, const CameraChoice& choice,
                         const FrameOptions& frame) {
  check_rules(command, {{choice.several() || frame.modes.size() > 1,
                         "it looks at one picture: choose one camera and one mode"},
                        {frame.modes.front() == kReferenceMode,
                         "mode reference has no tiles: choose another mode"}});
}

std::vector<Shot> choose_shots(const CameraChoice& choice, const FrameOptions& frame,
                               const Session& session) {
  if (!choice.indices.empty() + choice.json.has_value() + choice.all + choice.path.has_value() >
      1) {
    fail(ErrorKind::usage,
         "--camera-index, --camera-json, --all-cameras and --camera-path exclude each other");
  }
  if (choice.steps && !choice.path) fail(ErrorKind::usage, "--path-steps needs a --camera-path");
  std::vector<Shot> shots = unsized_shots(choice, frame, session);
  const glm::dvec3& origin = session.scene->cloud.origin;
  for (Shot& shot : shots) {
    if (choice.json || choice.path) shot.camera = shot.camera.placed(origin);
    shot.camera.origin = origin;
  }
  if (frame.size)
    for (Shot& shot : shots) shot.camera = shot.camera.resized(frame.size->x, frame.size->y);
  return shots;
}

std::vector<Shot> choose_shots_or_all(CameraChoice choice, const FrameOptions& frame,
                                      const Session& session) {
  choice.usually_all = true;
  return choose_shots(choice, frame, session);
}

}  // namespace qs
