// SPDX-License-Identifier: MIT
//
// Small scenes with cameras, opened as the server opens them.
#pragma once

#include "app/serve/served_scene.h"
#include "learn/lod/build.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {

struct SmallScenes {
  TemporaryFolder folder;
  ServedScenes scenes;
  std::vector<const OpenedScene*> opened;

  /// With a budget the scenes are trees of levels of detail.
  explicit SmallScenes(int count = 2, std::optional<int> budget = {}) {
    for (int i = 0; i < count; ++i) {
      const auto own = folder / ("secret" + std::to_string(i));
      std::filesystem::create_directory(own);
      auto path = own / ("scene" + std::to_string(i) + ".ply");
      write_scene(random_cloud(300, 1, static_cast<unsigned>(i + 1)), path);
      Camera second = front_camera(64, 48);
      second.view_from_world[3].x = 0.3;
      write_cameras({front_camera(64, 48), second}, own / "cameras.json");
      if (budget) {
        LodBuild build;
        build.inputs = {path};
        build.output = path.replace_extension(".rad");
        build.original = true;
        build.warn = [](const std::string&) {};
        build_lod(build, pool());
      }
      FrameOptions frame;
      frame.levels.budget = budget;
      frame.scene = path;
      frame.backend = Backend::cpu;
      frame.threads = 1;
      scenes.push_back(open_served_scene(frame));
      opened.push_back(&scenes.back()->opened);
    }
  }
};

}  // namespace qs::test
