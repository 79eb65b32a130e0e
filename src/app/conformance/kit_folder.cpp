// SPDX-License-Identifier: MIT
#include <utility>

#include <nlohmann/json.hpp>

#include "app/conformance/kit_scenes.h"
#include "base/json_of.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/json_text.h"
#include "io/bytes/replace_file.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "io/scene/writer.h"

namespace qs {
namespace {

using Json = nlohmann::ordered_json;

// Rows of the 3x4 matrix.
Json matrix_json(const glm::dmat4x3& matrix) {
  const auto row = [&](int r) {
    return Json{matrix[0][r], matrix[1][r], matrix[2][r], matrix[3][r]};
  };
  return {row(0), row(1), row(2)};
}

Json scene_entry(const KitScene& scene, const KitView& view) {
  const std::string name = scene.name;
  const Camera& camera = view.camera;
  return {{"name", name},
          {"tests", scene.what},
          {"scene", name + ".ply"},
          {"cameras", name + ".cameras.json"},
          {"truth", "truth/" + name + ".png"},
          {"width", camera.width},
          {"height", camera.height},
          {"fx", camera.focal_px.x},
          {"fy", camera.focal_px.y},
          {"view_from_world", matrix_json(camera.view_from_world)},
          {"background", json_of(view.settings.background)},
          {"sh_degree", view.cloud.sh_degree},
          {"antialiased", view.cloud.antialiased}};
}

void write_kit_files(const std::filesystem::path& folder, ThreadPool& pool,
                     const Progress& progress) {
  std::filesystem::create_directory(folder / "truth");
  Json scenes = Json::array();
  for (const KitScene& scene : kit_scenes()) {
    KitView view = scene.make();
    view.camera.name = scene.name;
    const std::string name = scene.name;
    write_scene(view.cloud, folder / (name + ".ply"), pool);
    write_text(folder / (name + ".cameras.json"), format_cameras({{view.camera, {}}}));
    const Image truth = truth_of(view, pool);
    write_image(truth, folder / "truth" / (name + ".png"));
    write_image(truth, folder / "truth" / (name + ".pfm"));
    scenes.push_back(scene_entry(scene, view));
    progress.update(static_cast<float>(scenes.size()) / static_cast<float>(kit_scenes().size()));
  }
  const Json kit = {{"axes", "x right, y down, z forward"},
                    {"pixels",
                     "the centre of the first pixel is at (0, 0), the principal point at "
                     "((width - 1) / 2, (height - 1) / 2)"},
                    {"near_depth", Camera{}.near_depth},
                    {"scenes", std::move(scenes)}};
  write_text(folder / "kit.json", json_file_text(kit));
}

}  // namespace

Image truth_of(const KitView& view, ThreadPool& pool) {
  const auto renderer = make_renderer(Backend::cpu, pool);
  renderer->upload(view.cloud, {});
  RenderSettings settings = view.settings;
  settings.mode = kReferenceMode;
  return renderer->render(view.camera, settings).color;
}

void write_kit(const std::filesystem::path& folder, ThreadPool& pool, const Progress& progress) {
  require_new_folder(folder, may_overwrite());
  replace_folder(folder, [&](const std::filesystem::path& hidden) {
    write_kit_files(hidden, pool, progress);
  });
}

}  // namespace qs
