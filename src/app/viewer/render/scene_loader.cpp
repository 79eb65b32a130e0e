// SPDX-License-Identifier: MIT
#include "app/viewer/render/scene_loader.h"

#include <system_error>

#include <fmt/format.h>

#include "app/framing/camera_rig.h"
#include "app/framing/framing.h"
#include "app/framing/huge_gaussians.h"
#include "app/measure/scene_facts.h"
#include "app/session/photographs.h"
#include "app/viewer/render/render_context.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxCamerasBytes = std::size_t{256} << 20;

// True for cameras and paths; meta.json and lod-meta.json are scenes.
bool is_json(const fs::path& path) {
  return path.extension() == ".json" && !path.filename().string().ends_with("meta.json");
}

// Only paths of keyframes hold times.
bool is_camera_path(const fs::path& path) {
  return read_text_file(path, kMaxCamerasBytes).find("\"time\"") != std::string::npos;
}

template <class Read>
bool succeeds(Read read) {
  try {
    return read();
  } catch (const Error&) {
    return false;
  }
}

// A folder without a scene in it may hold the cameras of a data set.
bool is_cameras_folder(const fs::path& folder) {
  std::error_code error;
  return fs::is_directory(folder, error) &&
         !succeeds([&] { return find_scene_file(folder), true; }) &&
         succeeds([&] { return !read_cameras(folder).empty(); });
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

namespace {

// choose(up) chooses a framing if there are no cameras.
template <class Choose>
ViewedScene view_facts_with(const Scene& scene, const std::optional<fs::path>& cameras_file,
                            const std::optional<glm::dvec3>& given_up, const Choose& choose) {
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
  facts.huge = count_huge(scene.cloud, scene_length(facts.core, facts.smallest_radius));
  if (const auto file = cameras_file ? cameras_file : find_cameras_file(scene.path)) {
    facts.cameras_file = *file;
    facts.cameras = read_cameras(*file);
    facts.photographs = find_photographs(*file, facts.cameras);
  }
  facts.landmarks = landmarks_of(scene.cloud);
  const std::optional<glm::dvec3> up = declared_up(given_up, scene.vertical_axis);
  facts.up_is_declared = up.has_value();
  facts.framing = subject_framing(facts.cameras, up, [&] { return choose(up); });
  facts.up = facts.framing.up;
  return facts;
}

}  // namespace

ViewedScene view_facts(const Scene& scene, const std::optional<fs::path>& cameras_file,
                       ThreadPool& pool, const std::optional<glm::dvec3>& given_up) {
  return view_facts_with(scene, cameras_file, given_up, [&](const std::optional<glm::dvec3>& up) {
    return choose_framing(scene.cloud, up, pool);
  });
}

namespace {

// Uses a sample while the rest of the scene is read: a separate thread chooses the first view and
// reports the sample and the view.
class EarlyView {
 public:
  EarlyView(ActionQueue& reports, const OpenRequest& request)
      : reports_(reports), request_(request) {}

  void begin(SceneSample sample) {
    thread_ = std::jthread([this, sample = std::move(sample)](const std::stop_token& stop) mutable {
      try {
        work(std::move(sample), stop);
      } catch (const std::exception&) {  // the scene itself fails too, with a message
      }
    });
  }

  // The framing of the scene: the sample's framing if no Gaussian was dropped since.
  std::optional<Framing> framing_of(const Scene& scene) {
    if (thread_.joinable()) thread_.join();
    return scene.cloud.size() == of_ ? framing_ : std::nullopt;
  }

 private:
  void work(SceneSample sample, const std::stop_token& stop) {
    ThreadPool pool(1);
    if (request_.skip_huge) drop_huge(sample.scene.cloud);
    const auto read = std::make_shared<ReadSample>();
    read->facts = view_facts_with(
        sample.scene, request_.cameras_file, request_.up,
        [&](const auto& up) { return choose_framing(sample_of(sample), up, pool); });
    read->facts.axes = request_.axes;
    read->facts.declared_axes = sample.scene.declared_axes;
    framing_ = read->facts.framing;
    of_ = sample.of;
    read->sample = std::move(sample);
    if (!stop.stop_requested())
      reports_.report(action::sample_read, read, request_.keep_background);
  }

  ActionQueue& reports_;
  const OpenRequest& request_;
  std::optional<Framing> framing_;
  std::size_t of_ = 0;
  std::jthread thread_;
};

}  // namespace

void SceneLoader::open(const OpenRequest& request) {
  cancel();
  reports_.report(action::show_progress, Loading{request.path, "reading", 0});
  ++reading_;
  thread_ = std::jthread([this, request](const std::stop_token& stop) {
    try {
      read(request, stop);
    } catch (const Cancelled&) {
      reports_.report(action::notify,
                      fmt::format("{}: cancelled", request.path.filename().string()));
      reports_.report(action::end_progress);
    } catch (const std::exception& error) {
      reports_.report(action::notify_error, std::string(error.what()));
      reports_.report(action::end_progress);
    }
    --reading_;
  });
}

void SceneLoader::cancel() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

void SceneLoader::read_photograph(const fs::path& path) {
  ++reading_;
  photograph_thread_ = std::jthread([this, path] {
    try {
      ThreadPool pool(1);
      ShownPhotograph photograph{
          path, std::make_shared<Image>(qs::read_photograph(path, glm::vec3(0), 1, pool))};
      reports_.report(action::photograph_opened, std::move(photograph));
    } catch (const std::exception& error) {
      reports_.report(action::notify_error, std::string(error.what()));
    }
    --reading_;
  });
}

void SceneLoader::read_beside(const fs::path& path, const ReadOptions& options, bool skip_huge,
                              const std::stop_token& stop) {
  ThreadPool pool(threads_);
  Scene read = read_scene(path, pool, options);
  if (skip_huge) drop_huge(read.cloud);
  const auto scene = std::make_shared<const Scene>(std::move(read));
  for (const std::string& warning : scene->warnings) reports_.report(action::notify, warning);
  if (stop.stop_requested()) throw Cancelled{};
  reports_.report(action::show_progress, Loading{path, "uploading", 0});
  reports_.report(action::beside_read, scene);
}

void SceneLoader::read(const OpenRequest& request, const std::stop_token& stop) {
  const fs::path& path = request.path;
  if (is_json(path) && is_camera_path(path)) {
    reports_.report(action::set_keyframes, read_camera_path(path));
    return reports_.report(action::end_progress);
  }
  if (is_json(path) || is_cameras_folder(path)) {
    const std::vector<Camera> cameras = read_cameras(path);
    reports_.report(action::cameras_opened, cameras, path, find_photographs(path, cameras));
    return reports_.report(action::end_progress);
  }
  ReadOptions options;
  options.iteration = request.iteration;
  options.axes = request.axes;
  options.progress = shown_progress(path, "reading", stop, reports_);
  if (request.beside) return read_beside(path, options, request.skip_huge, stop);
  EarlyView early(reports_, request);
  options.sampling = sampling_;
  options.sampling.take = [&](SceneSample sample) { early.begin(std::move(sample)); };
  const auto loaded = std::make_shared<LoadedScene>();
  ThreadPool pool(threads_);
  loaded->scene = read_scene(path, pool, options);
  const std::optional<Framing> framing = early.framing_of(loaded->scene);
  const std::size_t skipped = request.skip_huge ? drop_huge(loaded->scene.cloud) : 0;
  if (framing) {
    loaded->facts = view_facts_with(loaded->scene, request.cameras_file, request.up,
                                    [&](const auto&) { return *framing; });
  } else {
    loaded->facts = view_facts(loaded->scene, request.cameras_file, pool, request.up);
  }
  loaded->facts.axes = request.axes;
  loaded->facts.declared_axes = loaded->scene.declared_axes;
  loaded->facts.skipped_huge = skipped;
  for (const std::string& warning : loaded->scene.warnings)
    reports_.report(action::notify, warning);
  if (stop.stop_requested()) throw Cancelled{};
  reports_.report(action::show_progress, Loading{path, "uploading", 0});
  reports_.report(action::scene_read, loaded, request.keep_background);
}

}  // namespace qs
