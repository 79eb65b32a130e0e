// SPDX-License-Identifier: MIT
#include "app/viewer/render/scene_loader.h"

#include <system_error>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "app/measure/scene_facts.h"
#include "app/session/camera_control.h"
#include "app/session/framing.h"
#include "app/session/photographs.h"
#include "app/viewer/render/render_context.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxCamerasBytes = std::size_t{256} << 20;

// Photographers hold cameras upright on the whole.
glm::dvec3 mean_up(const std::vector<Camera>& cameras, glm::dvec3 otherwise) {
  glm::dvec3 sum(0);
  for (const Camera& camera : cameras) sum -= view_axes(camera).down;
  const double length = glm::length(sum);
  return length > 0.1 * static_cast<double>(cameras.size()) && length > 0 ? sum / length
                                                                          : otherwise;
}

// meta.json and lod-meta.json are scenes.
bool is_json(const fs::path& path) {
  return path.extension() == ".json" && !path.filename().string().ends_with("meta.json");
}

// A path of keyframes gives times; other camera files do not.
bool is_camera_path(const fs::path& path) {
  return read_text_file(path, kMaxCamerasBytes).find("\"time\"") != std::string::npos;
}

// A folder without a scene in it may be a data set's cameras.
bool has_scene(const fs::path& path) {
  try {
    find_scene_file(path);
    return true;
  } catch (const Error&) {
    return false;
  }
}

bool has_cameras(const fs::path& folder) {
  try {
    return !read_cameras(folder).empty();
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

std::map<int, fs::path> find_photographs(const fs::path& cameras_file,
                                         const std::vector<Camera>& cameras) {
  std::map<int, fs::path> found;
  for (const fs::path& folder : {cameras_file.parent_path(), cameras_file.parent_path() / ".."}) {
    std::error_code error;
    if (!fs::is_directory(folder / "images", error)) continue;
    const Photographs photographs(folder / "images");
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      if (const auto path = photographs.find(cameras[i].name)) found[static_cast<int>(i)] = *path;
    }
    break;
  }
  return found;
}

ViewedScene view_facts(const Scene& scene, const std::optional<fs::path>& cameras_file) {
  ViewedScene facts;
  facts.path = scene.path;
  facts.name = scene_name(scene.path);
  facts.format = scene.format;
  facts.gaussians = scene.cloud.size();
  facts.file_bytes = scene.file_bytes;
  facts.sh_degree = scene.cloud.sh_degree;
  facts.antialiased = scene.cloud.antialiased;
  facts.white_background = model_wants_white_background(scene.path);
  facts.core = core_box(scene.cloud);
  facts.smallest_radius = smallest_framing(scene.cloud);
  if (const auto file = cameras_file ? cameras_file : find_cameras_file(scene.path)) {
    facts.cameras_file = *file;
    facts.cameras = read_cameras(*file);
    facts.photographs = find_photographs(*file, facts.cameras);
  }
  facts.up = facts.cameras.empty() || !scene.vertical_axis.empty()
                 ? world_up(scene.vertical_axis)
                 : mean_up(facts.cameras, world_up(scene.vertical_axis));
  return facts;
}

void SceneLoader::start(const fs::path& path, int iteration,
                        const std::optional<fs::path>& cameras_file, const std::string& axes) {
  cancel();
  report(action::SetLoading{Loading{path, "reading", 0}});
  {
    const std::lock_guard lock(mutex_);
    reading_ = true;
  }
  thread_ = std::jthread([this, path, iteration, cameras_file, axes](const std::stop_token& stop) {
    try {
      read(path, iteration, cameras_file, axes, stop);
    } catch (const Cancelled&) {
      report(action::Say{fmt::format("{}: cancelled", path.filename().string())});
      report(action::SetLoading{});
    } catch (const std::exception& error) {
      report(action::Say{error.what(), true});
      report(action::SetLoading{});
    }
    const std::lock_guard lock(mutex_);
    reading_ = false;
  });
}

void SceneLoader::cancel() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  const std::lock_guard lock(mutex_);
  loaded_.reset();
}

std::optional<LoadedScene> SceneLoader::poll(Actions& actions) {
  const std::lock_guard lock(mutex_);
  for (Action& report : reports_) actions.push_back(std::move(report));
  reports_.clear();
  return std::exchange(loaded_, std::nullopt);
}

bool SceneLoader::busy() {
  const std::lock_guard lock(mutex_);
  return reading_ || loaded_ || !reports_.empty();
}

void SceneLoader::read(const fs::path& path, int iteration,
                       const std::optional<fs::path>& cameras_file, const std::string& axes,
                       const std::stop_token& stop) {
  std::error_code error;
  const bool folder = fs::is_directory(path, error);
  if (is_json(path) && is_camera_path(path)) {
    report(action::SetKeyframes{read_camera_path(path)});
    return report(action::SetLoading{});
  }
  if (is_json(path) || (folder && !has_scene(path) && has_cameras(path))) {
    const std::vector<Camera> cameras = read_cameras(path);
    report(action::CamerasOpened{cameras, path, find_photographs(path, cameras)});
    return report(action::SetLoading{});
  }
  ReadOptions options;
  options.iteration = iteration;
  options.axes = axes;
  options.progress =
      loading_progress(path, "reading", stop, [this](Action action) { report(std::move(action)); });
  LoadedScene loaded;
  ThreadPool pool(threads_);
  loaded.scene = read_scene(path, pool, options);
  loaded.facts = view_facts(loaded.scene, cameras_file);
  loaded.facts.axes = axes;
  for (const std::string& warning : loaded.scene.warnings) report(action::Say{warning});
  if (stop.stop_requested()) throw Cancelled{};
  report(action::SetLoading{Loading{path, "uploading", 0}});
  const std::lock_guard lock(mutex_);
  loaded_ = std::move(loaded);
}

void SceneLoader::report(Action action) {
  {
    const std::lock_guard lock(mutex_);
    reports_.push_back(std::move(action));
  }
  wake_();
}

}  // namespace qs
