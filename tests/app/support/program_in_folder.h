// SPDX-License-Identifier: MIT
//
// The program in a folder with a small scene, a camera and its photograph.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/support/run_program.h"
#include "base/text.h"
#include "io/picture/image_file.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {

class ProgramInFolder : public testing::Test {
 protected:
  void SetUp() override {
    GaussianCloud cloud = random_cloud(300, 1, 11);
    cloud.positions[0] = {0, 0, 3};
    cloud.opacity_logits[0] = 8;
    edit(cloud);
    write_scene(cloud, folder_ / "scene.ply");
    Camera camera = front_camera(32, 24);
    camera.name = "view";
    write_cameras({camera}, folder_ / "cameras.json");
    std::filesystem::create_directories(folder_ / "images");
    write_image(Image(32, 24, 3), folder_ / "images/view.pfm");
  }

  virtual void edit(GaussianCloud&) {}

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  // Words that begin with @ are files of the folder.
  ProgramRun run(const std::string& line, const std::function<void(pid_t)>& meanwhile = {}) const {
    std::vector<std::string> words;
    for (const std::string& word : separated(line, ' '))
      words.push_back(word.starts_with('@') ? path(word.substr(1)) : word);
    return run_quadsplat(words, meanwhile);
  }

  TemporaryFolder folder_;
};

}  // namespace qs::test
