// SPDX-License-Identifier: MIT
#include "app/viewer/render/scene_reading.h"

#include <system_error>
#include <thread>
#include <utility>

#include "app/framing/first_view.h"
#include "app/framing/scene_box.h"
#include "app/framing/whole_subject.h"
#include "app/measure/scene_facts.h"
#include "app/session/levels.h"
#include "app/session/placed_cameras.h"
#include "app/viewer/render/render_context.h"
#include "base/fail.h"
#include "base/path_kind.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/camera/photographs.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

using Report = std::function<void(ReadingReport)>;

constexpr std::size_t kMaxCamerasBytes = std::size_t{256} << 20;
constexpr std::uint64_t kPageMemory = 3'000'000'000;  // of a tree, beside other programs

// Scenes and other files are `none`.
JsonKind kind_of_cameras(const fs::path& path) {
  if (path.extension() != ".json") return JsonKind::none;
  const JsonKind kind = json_kind(read_text_file(path, kMaxCamerasBytes));
  // The name of an unknown object decides which reader names its defect.
  const bool is_scene =
      kind == JsonKind::sog || kind == JsonKind::streamed_sog || kind == JsonKind::gltf ||
      kind == JsonKind::instances ||
      (kind == JsonKind::other && path.filename().string().ends_with("meta.json"));
  return is_scene ? JsonKind::none : kind;
}

// A folder without a scene in it may hold the cameras of a data set.
bool is_cameras_folder(const fs::path& folder) try {
  return is_folder(folder) && !holds_scene(folder) && !read_cameras(folder).empty();
} catch (const Error&) {
  return false;
}

// Uses a sample while the rest of the scene is read: a separate thread chooses the first view and
// reports the sample and the view.
class EarlyView {
 public:
  EarlyView(const Report& report, const OpenRequest& request)
      : report_(report), request_(request) {}

  void begin(SceneSample sample) {
    thread_ = std::jthread([this, sample = std::move(sample)](const std::stop_token& stop) mutable {
      try {
        work(std::move(sample), stop);
      } catch (const std::exception&) {  // the scene itself fails too, with a message
      }
    });
  }

  // The framings of the scene: the sample's framings if no Gaussian was dropped since, else none.
  std::vector<Framing> framings_of(const Scene& scene) {
    if (thread_.joinable()) thread_.join();
    return scene.cloud.size() == of_ && scene.cloud.origin == origin_ ? framings_
                                                                      : std::vector<Framing>();
  }

 private:
  void work(SceneSample sample, const std::stop_token& stop) {
    ThreadPool pool(1);
    if (request_.skip_huge) drop_huge(sample.scene.cloud);
    ReadSample read;
    read.facts = view_facts_with(
        sample.scene, request_.cameras_file, request_.up,
        [&](const auto& up) { return choose_framings(sample_of(sample), up, pool); });
    read.facts.axes = request_.axes;
    read.facts.declared_axes = sample.scene.declared_axes;
    framings_ = read.facts.candidates;
    if (framings_.empty()) framings_ = {read.facts.framing};
    of_ = sample.of;
    origin_ = sample.scene.cloud.origin;
    read.sample = std::make_shared<SceneSample>(std::move(sample));
    if (!stop.stop_requested()) report_(std::move(read));
  }

  const Report& report_;
  const OpenRequest& request_;
  std::vector<Framing> framings_;
  std::size_t of_ = 0;
  glm::dvec3 origin_{0};
  std::jthread thread_;
};

// Draws all leaves of a tree, also beside its levels.
LoadedScene read_beside(const OpenRequest& request, int threads, ReadOptions options) {
  ThreadPool pool(threads);
  options.streams = StreamedTrees::large;
  Scene scene = read_scene(request.path, pool, options);
  if (scene.stream)
    fail("{}: all its leaves would take more than half of the memory", scene.path.string());
  if (request.skip_huge) drop_huge(scene);
  return {std::make_shared<const Scene>(std::move(scene))};
}

LoadedScene read_whole(const OpenRequest& request, int threads, ReadOptions options,
                       const Report& report) {
  EarlyView early(report, request);
  options.sampling.take = [&](SceneSample sample) { early.begin(std::move(sample)); };
  ThreadPool pool(threads);
  Scene scene = open_scene(request.path, pool, options);
  apply_edits(scene, request.edits, pool);
  const std::vector<Framing> framings = early.framings_of(scene);
  const std::size_t skipped = request.skip_huge ? drop_huge(scene) : 0;
  LoadedScene loaded;
  loaded.facts = framings.empty() ? view_facts(scene, request.cameras_file, pool, request.up)
                                  : view_facts_with(scene, request.cameras_file, request.up,
                                                    [&](const auto&) { return framings; });
  loaded.facts.axes = request.axes;
  loaded.facts.declared_axes = scene.declared_axes;
  loaded.facts.skipped_huge = skipped;
  loaded.scene = std::make_shared<const Scene>(std::move(scene));
  return loaded;
}

ReadingReport read_any(const OpenRequest& request, int threads, Sampling sampling,
                       const Report& report, const std::stop_token& stop) {
  const fs::path& path = request.path;
  const JsonKind kind = kind_of_cameras(path);
  if (kind == JsonKind::camera_path) return OpenedPath{read_camera_path(path)};
  if (kind != JsonKind::none || is_cameras_folder(path)) {
    const CameraSet set = read_camera_set(path);
    if (set.cameras.empty()) fail("{}: holds no camera", path.string());
    std::vector<Camera> cameras = pinhole_cameras(set.cameras);
    auto photographs = find_photographs(path, cameras);
    return OpenedCameras{std::move(cameras), path, std::move(photographs),
                         joined(set.pinhole_sentences(), "; ")};
  }
  ReadOptions options;
  options.iteration = request.iteration;
  options.axes = request.axes;
  options.streams = request.streams;
  options.page_memory = kPageMemory;
  options.progress = stepped_progress(
      [&](float fraction) {
        report(Loading{path, "reading", fraction});
      },
      stop);
  if (request.beside) return read_beside(request, threads, options);
  options.sampling = std::move(sampling);
  return read_whole(request, threads, std::move(options), report);
}

}  // namespace

void read_to_open(const OpenRequest& request, int threads, Sampling sampling,
                  const std::function<void(ReadingReport)>& report, const std::stop_token& stop) {
  ReadingReport last = read_any(request, threads, std::move(sampling), report, stop);
  if (stop.stop_requested()) throw Cancelled{};
  report(std::move(last));
}

std::map<int, fs::path> find_photographs(const fs::path& cameras_file,
                                         const std::vector<Camera>& cameras) {
  std::map<int, fs::path> found;
  for (const fs::path& folder : {cameras_file.parent_path(), cameras_file.parent_path() / ".."}) {
    if (!is_folder(folder / "images")) continue;
    const Photographs photographs(folder / "images");
    for (std::size_t i = 0; i < cameras.size(); ++i) try {
        if (const auto path = photographs.find(cameras[i].name)) found[static_cast<int>(i)] = *path;
      } catch (const Error&) {  // two photographs have this name: none is shown
      }
    break;
  }
  return found;
}

ViewedScene view_facts_with(
    const Scene& scene, const std::optional<fs::path>& cameras_file,
    const std::optional<glm::dvec3>& given_up,
    const std::function<std::vector<Framing>(const std::optional<glm::dvec3>& up)>& choose) {
  ViewedScene facts;
  facts.path = scene.path;
  facts.name = scene_name(scene.path);
  facts.format = scene.format;
  facts.gaussians = scene.cloud.size();
  if (scene.stream) facts.nodes = scene.levels->nodes;
  facts.file_bytes = scene.file_bytes;
  facts.sh_degree = scene.cloud.sh_degree;
  facts.antialiased = scene.cloud.antialiased;
  facts.edits = scene.edits;
  facts.origin = scene.cloud.origin;
  facts.white_background = model_wants_white_background(scene.path);
  facts.core = core_box(scene.cloud);
  facts.subject = subject_box(scene.cloud);
  facts.smallest_radius = smallest_framing(scene.cloud);
  facts.huge = count_huge(scene.cloud, scene_length(facts.core, facts.smallest_radius));
  if (const auto file = cameras_file ? cameras_file : find_cameras_file(scene.path)) {
    facts.cameras_file = *file;
    const PlacedCameras placed = placed_cameras(*file, scene, cameras_file.has_value());
    facts.cameras = placed.cameras;
    facts.cameras_warning = joined(placed.warnings, "; ");
    facts.photographs = find_photographs(*file, facts.cameras);
  }
  facts.landmarks = landmarks_of(scene.cloud);
  const std::optional<glm::dvec3> up = declared_up(given_up, scene.vertical_axis);
  facts.up_is_declared = up.has_value();
  facts.framing = subject_framing(facts.cameras, up, [&] {
    facts.candidates = choose(up);
    return facts.candidates.front();
  });
  facts.up = facts.framing.up;
  return facts;
}

ViewedScene view_facts(const Scene& scene, const std::optional<fs::path>& cameras_file,
                       ThreadPool& pool, const std::optional<glm::dvec3>& given_up) {
  return view_facts_with(scene, cameras_file, given_up, [&](const std::optional<glm::dvec3>& up) {
    return choose_framings(scene.cloud, up, pool);
  });
}

}  // namespace qs
