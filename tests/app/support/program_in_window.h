// SPDX-License-Identifier: MIT
//
// Runs `view` in a real window of 320 x 240 pixels: Xvfb, software OpenGL, the CPU backend,
// scripted input.
#pragma once

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/support/run_program.h"
#include "app/support/virtual_display.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {

// One X server for all tests of a file.
inline VirtualDisplay& display() {
  static VirtualDisplay server("1280x720x24");
  return server;
}

class ProgramInWindow : public testing::Test {
 protected:
  void SetUp() override {
    if (!display().runs()) GTEST_SKIP() << "Xvfb is not installed";
    GaussianCloud cloud = random_cloud(400, 0, 3);
    append(cloud, single_gaussian({0, 0, 4}, 0.5f, {0.9f, 0.4f, 0.1f}, 5));
    write_scene(cloud, path("scene.ply"));
    std::vector<Camera> cameras;
    for (const double x : {0.0, 0.3}) {
      Camera camera = front_camera(320, 240);
      camera.view_from_world[3].x = x;
      cameras.push_back(camera);
    }
    write_cameras(cameras, folder_ / "cameras.json");
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  ProgramRun play(const std::string& script, std::vector<std::string> arguments = {},
                  const std::function<void(pid_t)>& meanwhile = {}) {
    std::ofstream(folder_ / "script") << script;
    for (const std::string& word : {std::string("--input"), path("script"),
                                    std::string("--out-dir"), folder_.path().string()})
      arguments.push_back(word);
    if (std::find(arguments.begin(), arguments.end(), "--settings") == arguments.end())
      arguments.insert(arguments.end(), {"--settings", "-"});
    if (std::find(arguments.begin(), arguments.end(), "--size") == arguments.end())
      arguments.insert(arguments.end(), {"--size", "320x240"});
    arguments.insert(arguments.begin(), {"view", "--backend", "cpu", "--threads", "2"});
    return run_quadsplat(arguments, meanwhile);
  }

  nlohmann::json state(const std::string& name) const {
    return parse_json(read_text_file(folder_ / name, 1 << 20), "test");
  }

  TemporaryFolder folder_;
};

}  // namespace qs::test
