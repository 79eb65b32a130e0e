// SPDX-License-Identifier: MIT
//
// Opening a scene, naming files and boxes of scenes: exact values.
#include "app/session/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/scene_box.h"
#include "app/session/shot.h"
#include "base/error.h"
#include "io/scene/writer.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

class SessionTest : public testing::Test {
 protected:
  SessionTest() {
    frame_.scene = folder_ / "scene.ply";
    test::write_scene(test::random_cloud(60, 1, 3), frame_.scene);
  }

  TemporaryFolder folder_;
  FrameOptions frame_;
};

TEST_F(SessionTest, has_the_settings_that_were_asked_for) {
  frame_.modes = {find_culler("adr"), find_culler("exact")};
  frame_.backend = Backend::cpu;
  frame_.settings.pipeline = Pipeline::classic;
  frame_.settings.sh_degree = 1;
  frame_.settings.splat_scale = 0.75f;
  frame_.background = glm::vec3(0.25f, 0.5f, 0.75f);
  frame_.settings.antialiased = true;
  frame_.settings.tile_px = 32;
  frame_.device = 7;
  const Session session = open_session(frame_, [](Scene& scene) { scene.cloud.sh[0].x = 5; });
  EXPECT_EQ(session.backend, Backend::cpu);
  EXPECT_EQ(session.device, 7);
  EXPECT_EQ(session.settings.mode, find_culler("adr"));
  EXPECT_EQ(session.settings.pipeline, Pipeline::classic);
  EXPECT_EQ(session.settings.sh_degree, 1);
  EXPECT_EQ(session.settings.splat_scale, 0.75f);
  EXPECT_EQ(session.settings.background, glm::vec3(0.25f, 0.5f, 0.75f));
  EXPECT_EQ(session.settings.antialiased, true);
  EXPECT_EQ(session.settings.tile_px, 32);
  EXPECT_EQ(session.scene->cloud.sh[0].x, 5);
  EXPECT_STREQ(pipeline_name(session.backend, session.settings.pipeline), "classic");
}

TEST_F(SessionTest, only_the_cpu_draws_the_reference_and_other_tile_sizes) {
  frame_.modes = {kReferenceMode};
  EXPECT_EQ(open_session(frame_).backend, Backend::cpu);
  frame_.backend = Backend::cuda;
  EXPECT_THROW(open_session(frame_), Error);
  frame_.modes = {default_mode()};
  frame_.settings.tile_px = 8;
  EXPECT_THROW(open_session(frame_), Error);
  frame_.backend.reset();
  EXPECT_EQ(open_session(frame_).backend, Backend::cpu);
}

TEST_F(SessionTest, the_reference_image_is_that_of_mode_reference_on_the_cpu) {
  frame_.backend = Backend::cpu;
  Session session = open_session(frame_);
  EXPECT_EQ(&renderer_on(session, Backend::cpu), session.renderer.get());
  EXPECT_EQ(session.second, nullptr);
  const Camera camera = test::front_camera(32, 24);
  const Image image = reference_image(session, camera);
  EXPECT_EQ(session.settings.mode, default_mode());
  RenderSettings settings;
  settings.mode = kReferenceMode;
  EXPECT_EQ(image.values, session.renderer->render(camera, settings).color.values);
}

TEST(Shot, names_files_by_number_and_camera) {
  Shot shot;
  EXPECT_EQ(with_shot("a/b.png", shot), "a/b.png");
  shot.number = 3;
  EXPECT_EQ(with_shot("a/b.png", shot), "a/b_0003.png");
  shot.camera.name = "x/y z-1.0_w";
  EXPECT_EQ(with_shot("a/b.png", shot), "a/b_0003_x_y_z-1.0_w.png");
}

TEST(SceneBox, leaves_out_five_per_cent_at_each_end_of_each_axis) {
  GaussianCloud cloud;
  cloud.resize(101, 0);
  for (std::size_t i = 0; i < 101; ++i) {
    const auto value = static_cast<float>(i * 37 % 101);
    cloud.positions[i] = {value, 10 * value, -value};
  }
  const SceneBox all = scene_box(cloud), core = core_box(cloud);
  EXPECT_EQ(all.low, glm::vec3(0, 0, -100));
  EXPECT_EQ(all.high, glm::vec3(100, 1000, 0));
  EXPECT_EQ(core.low, glm::vec3(5, 50, -95));
  EXPECT_EQ(core.high, glm::vec3(95, 950, -5));
  EXPECT_EQ(core.center(), glm::vec3(50, 500, -50));
  EXPECT_EQ(core.size(), glm::vec3(90, 900, 90));
}

}  // namespace
}  // namespace qs
