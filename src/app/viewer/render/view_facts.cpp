// SPDX-License-Identifier: MIT
#include "app/viewer/render/view_facts.h"

#include <system_error>

#include "app/framing/camera_rig.h"
#include "app/framing/framing.h"
#include "app/framing/huge_gaussians.h"
#include "app/framing/whole_subject.h"
#include "app/measure/scene_facts.h"
#include "io/camera/cameras.h"
#include "io/camera/photographs.h"

namespace qs {

namespace fs = std::filesystem;

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

ViewedScene view_facts_with(
    const Scene& scene, const std::optional<fs::path>& cameras_file,
    const std::optional<glm::dvec3>& given_up,
    const std::function<std::vector<Framing>(const std::optional<glm::dvec3>& up)>& choose) {
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
  facts.subject = subject_box(scene.cloud);
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
