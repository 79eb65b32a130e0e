// SPDX-License-Identifier: MIT
//
// A scene on the CPU backend for tests of code that explains frames.
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "app/inspect/inspection.h"
#include "base/parallel.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs::test {

class InspectorTest : public testing::Test {
 protected:
  InspectorTest() : renderer_(make_renderer(Backend::cpu, pool(2))), pool_(2) {
    renderer_->upload(cloud_, {});
  }

  Frame render(CullMode mode, int tile_px = kTileSize) {
    RenderSettings settings = settings_;
    settings.mode = mode;
    settings.tile_px = tile_px;
    Outputs outputs = inspection_outputs();
    outputs.pairs = outputs.used = outputs.evaluated = true;
    return renderer_->render(camera_, settings, outputs);
  }

  glm::ivec2 size() const { return {camera_.width, camera_.height}; }

  GaussianCloud cloud_ = random_cloud(4000, 1, 31);
  Camera camera_ = front_camera(200, 140);
  RenderSettings settings_ = [] {
    RenderSettings settings;
    settings.background = {0.1f, 0.3f, 0.2f};
    return settings;
  }();
  std::unique_ptr<Renderer> renderer_;
  ThreadPool pool_;
};

}  // namespace qs::test
