// SPDX-License-Identifier: MIT
#include "app/measure/scene_facts.h"

#include "io/bytes/file_hash.h"

namespace qs {

nlohmann::ordered_json scene_facts(const Scene& scene, const std::string& name) {
  return {{"name", name},
          {"file", scene.path.string()},
          {"hash", file_hash(scene.path)},
          {"bytes", scene.file_bytes},
          {"gaussians", scene.cloud.size()}};
}

std::string scene_name(const std::filesystem::path& scene_file) {
  const std::filesystem::path file = std::filesystem::absolute(scene_file);
  if (file.filename() != "point_cloud.ply") return file.stem().string();
  // MODEL/point_cloud/iteration_N/point_cloud.ply
  return file.parent_path().parent_path().parent_path().filename().string();
}

std::string picture_title(const std::filesystem::path& scene_file, const std::string& view) {
  return fmt::format("{} \u00b7 {}", scene_name(scene_file), view);
}

}  // namespace qs
