// SPDX-License-Identifier: MIT
//
// Crop and clean in the real program in a real window: chosen, seen, applied, undone, saved.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/session/removal_text.h"
#include "app/support/program_in_window.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

using nlohmann::json;
using test::ProgramRun;
using testing::HasSubstr;

using CropProgram = test::ProgramInWindow;

TEST_F(CropProgram, a_scene_is_cropped_seen_undone_and_saved) {
  const std::string steps = "wait\nkey Tab\nwait\nshot " + path("whole.png") +
                            "\nkey R\ncrop -9,-9,-9,0,9,9\nwait\nstate " + path("marked.json") +
                            "\nshot " + path("marked.png") + "\nkey Shift+R\nwait\nstate " +
                            path("applied.json") + "\nshot " + path("applied.png") +
                            "\nkey Ctrl+R\nwait\nstate " + path("saved.json") +
                            "\nkey Shift+R\nkey R\nwait\nstate " + path("undone.json") + "\nquit\n";
  const ProgramRun run = play(steps, {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;

  const Scene scene = test::read_scene(folder_ / "scene.ply");
  const CropBox box{{-9, -9, -9}, {0, 9, 9}};
  const Removal removal = find_removal(scene.cloud, box, {});
  ASSERT_GT(removal.going(), 0u);
  const json marked = state("marked.json"), applied = state("applied.json");
  EXPECT_EQ(marked["crop"]["text"], removal_text(removal, "would go"));
  EXPECT_EQ(marked["gaussians"], scene.cloud.size());
  EXPECT_EQ(marked["crop"]["applied"], false);
  EXPECT_EQ(applied["crop"]["text"],
            fmt::format("{} of {} Gaussians are left: {} removed", removal.staying(),
                        scene.cloud.size(), removal.going()));
  EXPECT_EQ(applied["gaussians"], removal.counts[0]);
  EXPECT_EQ(state("undone.json")["gaussians"], scene.cloud.size());
  EXPECT_FALSE(state("undone.json").contains("crop"));

  const Image whole = read_image(path("whole.png"));
  EXPECT_NE(read_image(path("marked.png")).values, whole.values);
  EXPECT_NE(read_image(path("applied.png")).values, read_image(path("marked.png")).values);

  EXPECT_THAT(state("saved.json")["toasts"].back().get<std::string>(),
              HasSubstr("scene_cropped_0001.ply"));
  const Scene saved = test::read_scene(folder_ / "scene_cropped_0001.ply");
  EXPECT_EQ(saved.cloud.positions, keep_rest(scene.cloud, removal).positions);
}

TEST_F(CropProgram, a_handle_is_dragged_with_the_mouse) {
  const Camera camera = test::front_camera(320, 240);
  const auto pixel_of = [&](glm::dvec3 point) {
    const glm::dvec2 pixel = glm::dvec2(point) / point.z * camera.focal_px + camera.center_px;
    return fmt::format("{:.0f} {:.0f}", pixel.x, pixel.y);
  };
  const std::string shot = "\nshot " + path("any.png") + "\n";
  const ProgramRun run =
      play("wait\nkey Tab\nkey R\ncrop -1,-1,4,1,1,6\nwait\nmove " + pixel_of({1, 0, 5}) + shot +
               "shot " + path("box.png") + "\npress left" + shot + "move " + pixel_of({1.4, 0, 5}) +
               shot + "release left" + shot + "wait\nstate " + path("a.json") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json a = state("a.json");
  const CropBox box = parse_crop_box("test", a["crop"]["box"].get<std::string>());
  EXPECT_NEAR(box.high.x, 1.4f, 0.03f);
  EXPECT_EQ(box.low, glm::vec3(-1, -1, 4));
  EXPECT_EQ(box.high.y, 1);
  EXPECT_EQ(a["dataset_camera"], 0) << "the camera stays where it is";
}

}  // namespace
}  // namespace qs
