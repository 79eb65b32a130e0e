// SPDX-License-Identifier: MIT
//
// The words and the JSON of settings and edits that alter a scene.
#include "app/session/alterations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/scene_box.h"
#include "app/session/shot.h"
#include "io/camera/lens_views.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// The scene of a model that was trained with white and without antialiasing.
SceneNature white_scene() { return {3, false, true, "RDF", "RDF", {}}; }
RenderSettings white_settings() {
  RenderSettings settings;
  settings.background = glm::vec3(1);
  return settings;
}

TEST(Alterations, say_nothing_of_a_scene_as_its_file_says) {
  RenderSettings settings = white_settings();
  settings.antialiased = false;  // as it is
  settings.mode = find_culler("3dgs");
  settings.pipeline = Pipeline::classic;
  const Alterations none = alterations_of(settings, white_scene());
  EXPECT_EQ(none.text, "");
  EXPECT_EQ(none.brief, "");
  EXPECT_TRUE(none.json.is_null());
  nlohmann::ordered_json report = {{"hash", "crc32:00000000"}};
  none.add_to(report);
  EXPECT_EQ(report.dump(), R"({"hash":"crc32:00000000"})");
}

TEST(Alterations, have_a_clause_and_a_member_for_every_setting) {
  struct Case {
    const char *text, *json;
    std::function<void(RenderSettings&, SceneNature&)> change;
  };
  const Case cases[] = {
      {"splat scale 0.5", R"({"splat_scale":0.5)", [](auto& s, auto&) { s.splat_scale = 0.5f; }},
      {"drawn as points", R"({"style":"points")",
       [](auto& s, auto&) { s.style = DrawStyle::points; }},
      {"SH degree 1 of 3", R"({"sh_degree":1)", [](auto& s, auto&) { s.sh_degree = 1; }},
      {"background 0,0.5,0", R"({"background":[0.0,0.5,0.0])",
       [](auto& s, auto&) {
         s.background = {0, 0.5f, 0};
       }},
      {"antialiased", R"({"antialiased":true)", [](auto& s, auto&) { s.antialiased = true; }},
      {"not antialiased", R"({"antialiased":false)",
       [](auto& s, auto& n) {
         n.antialiased = true;
         s.antialiased = false;
       }},
      {"hidden Gaussians may be left out", R"({"occlusion":true)",
       [](auto& s, auto&) { s.occlusion = true; }},
      {"lens orthographic, 2.5 units high", R"({"lens":"orthographic, 2.5 units high")",
       [](auto& s, auto&) { s.lens = std::make_shared<const LensView>(parallel_view(2.5)); }},
      {"tiles of 8 pixels", R"({"tile_px":8)", [](auto& s, auto&) { s.tile_px = 8; }},
      {"read with axes RFU", R"({"axes":"RFU")", [](auto&, auto& n) { n.axes = "RFU"; }},
      {"3 x 2 copies", R"({"copies":[3,2])",
       [](auto&, auto& n) {
         n.edits.copies = {3, 2};
       }},
      {"exact colours: all", R"({"exact_colors":"all")",
       [](auto&, auto& n) { n.exact_colors = "all"; }},
  };
  for (const Case& each : cases) {
    RenderSettings settings = white_settings();
    SceneNature scene = white_scene();
    each.change(settings, scene);
    const Alterations altered = alterations_of(settings, scene);
    EXPECT_EQ(altered.text, each.text);
    EXPECT_EQ(altered.brief, each.text);
    EXPECT_EQ(altered.json.dump(), fmt::format(R"({},"text":"{}"}})", each.json, each.text));
  }
}

TEST(Alterations, of_a_lens_name_its_faces_and_its_options) {
  RenderSettings settings = white_settings();
  LensView lens = panorama_view(180);
  lens.eye_distance = 0.065;
  lens.up = glm::dvec3(0, 0, 1);
  settings.lens = std::make_shared<const LensView>(lens);
  const Alterations altered = alterations_of(settings, white_scene());
  EXPECT_EQ(
      altered.text,
      "lens equirectangular of 180 degrees for eyes 0.065 apart, level (numbers are sums over "
      "its faces, 24 all round)");
  EXPECT_EQ(altered.brief, "lens equirectangular of 180 degrees");
}

TEST(Alterations, name_edits_by_their_number_their_rest_and_their_hash) {
  RenderSettings settings = white_settings();
  settings.splat_scale = 0.5625f;
  SceneNature scene = white_scene();
  Edits edits;
  edits.remove(34321, [](std::size_t i) { return i >= 23615; });
  scene.edits = edits;
  const Alterations altered = alterations_of(settings, scene);
  EXPECT_EQ(altered.brief, "splat scale 0.562, edited: 23,615 of 34,321 Gaussians");
  EXPECT_EQ(altered.text,
            "splat scale 0.562, edited: 1 step, 23,615 of 34,321 Gaussians, " + edits.crc);
  EXPECT_EQ(altered.json["edits"].dump(),
            R"({"steps":1,"kept":23615,"of":34321,"hash":")" + edits.crc + R"("})");
}

TEST(Edits, steps_count_in_the_file_s_own_order_and_the_hash_is_that_of_the_removed_bits) {
  Edits edits;
  edits.remove(10, [](std::size_t i) { return i < 2; });      // 0 and 1
  edits.remove(8, [](std::size_t i) { return i % 2 == 1; });  // of 2..9: 3, 5, 7, 9
  EXPECT_EQ(edits.steps, 2);
  EXPECT_EQ(edits.kept, 4u);
  EXPECT_EQ(edits.of, 10u);
  EXPECT_THAT(edits.removed.numbers(), ElementsAre(0u, 1u, 3u, 5u, 7u, 9u));
  EXPECT_EQ(edits.crc, "crc32:e22416f1");  // python3: zlib.crc32(bytes([0b10101011, 0b10]))
  Edits other;
  other.remove(10, [](std::size_t i) { return i < 2 || i % 2 == 1; });
  EXPECT_EQ(other.crc, edits.crc) << "however they were chosen";
}

TEST(Edits, leaving_out_huge_gaussians_is_a_step_in_the_session_and_its_pictures) {
  const TemporaryFolder folder;
  GaussianCloud cloud = test::random_cloud(60, 1, 3);
  cloud.log_scales[7] = glm::vec3(9);
  FrameOptions frame;
  frame.scene = folder / "scene.ply";
  frame.backend = Backend::cpu;
  test::write_scene(cloud, frame.scene);
  const Session whole = open_session(frame);
  EXPECT_EQ(altered_clause(whole), "");
  EXPECT_EQ(frame_metadata(whole, test::front_camera(8, 6), 1, {}).count("Altered"), 0u);
  frame.skip_huge = true;
  const Session rest = open_session(frame);
  EXPECT_TRUE(rest.scene->edits.removed[7]);
  EXPECT_THAT(altered_clause(rest), HasSubstr(", edited: 1 step, 59 of 60 Gaussians, crc32:"));
  EXPECT_EQ(", " + frame_metadata(rest, test::front_camera(8, 6), 1, {}).at("Altered"),
            altered_clause(rest));
}

}  // namespace
}  // namespace qs
