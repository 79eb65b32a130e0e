// SPDX-License-Identifier: MIT
#include "io/camera/cameras.h"

#include <fstream>
#include <functional>
#include <random>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "io/bytes/json_text.h"
#include "support/paths.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using nlohmann::json;
using testing::HasSubstr;

json valid_camera() {
  return {{"id", 0},
          {"img_name", "IMG_1.JPG"},
          {"width", 640},
          {"height", 480},
          {"position", {1.0, 2.0, 3.0}},
          {"rotation", {{0.0, -1.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}}},
          {"fx", 500.0},
          {"fy", 510.0}};
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::input);
    return error.what();
  }
  return "no error";
}

void expect_equal(const Camera& a, const Camera& b) {
  EXPECT_EQ(a.view_from_world, b.view_from_world);
  EXPECT_EQ(a.focal_px, b.focal_px);
  EXPECT_EQ(a.center_px, b.center_px);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.near_depth, b.near_depth);
  EXPECT_EQ(a.name, b.name);
}

TEST(Cameras, rotation_is_world_from_view_by_rows) {
  const Camera camera = parse_camera(valid_camera().dump(), "test");
  EXPECT_EQ(camera.position(), glm::dvec3(1, 2, 3));
  // The file's columns are the view's axes in the world: x right is (0, 1, 0), y down is (-1, 0,
  // 0).
  EXPECT_EQ(camera.view_from_world * glm::dvec4(1, 2 + 5, 3, 1), glm::dvec3(5, 0, 0));
  EXPECT_EQ(camera.view_from_world * glm::dvec4(1 - 5, 2, 3, 1), glm::dvec3(0, 5, 0));
  EXPECT_EQ(camera.view_from_world * glm::dvec4(1, 2, 3 + 5, 1), glm::dvec3(0, 0, 5));
}

TEST(Cameras, the_principal_point_is_the_image_centre_unless_given_at_pixel_corners) {
  EXPECT_EQ(parse_camera(valid_camera().dump(), "test").center_px, glm::dvec2(319.5, 239.5));
  json object = valid_camera();
  object["cx"] = 300;
  object["cy"] = 240.25;
  EXPECT_EQ(parse_camera(object.dump(), "test").center_px, glm::dvec2(299.5, 239.75));
}

TEST(Cameras, names_lose_the_ending_of_pictures_and_only_that) {
  EXPECT_EQ(parse_camera(valid_camera().dump(), "test").name, "IMG_1");
  json object = valid_camera();
  object["img_name"] = "frame.0001";
  EXPECT_EQ(parse_camera(object.dump(), "test").name, "frame.0001");
}

TEST(Cameras, any_camera_survives_being_written_and_read_bit_by_bit) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 200; ++trial) {
    Camera camera;
    const double size = std::pow(10, trial % 9 - 4);
    const glm::dquat turn(normal(random), normal(random), normal(random), normal(random));
    const glm::dmat3 rotation = glm::mat3_cast(glm::normalize(turn));
    camera.view_from_world =
        glm::dmat4x3(rotation[0], rotation[1], rotation[2],
                     size * glm::dvec3(normal(random), normal(random), normal(random)));
    camera.focal_px = {std::abs(normal(random)) + 1e-3, 1000.0 / 3};
    camera.center_px = 100.0 * glm::dvec2(normal(random), normal(random));
    camera.width = 1 + static_cast<int>(random() % 4000);
    camera.height = 1 + static_cast<int>(random() % 4000);
    camera.near_depth = 0.01 / 3;
    camera.name = "a \"b\" \u00fc/c";
    const std::string text = format_camera(camera);
    EXPECT_EQ(text.find('\n'), std::string::npos);
    expect_equal(parse_camera(text, "test"), camera);
  }
}

TEST(Cameras, editing_the_position_of_a_written_camera_moves_it) {
  Camera camera = look_at({1, 2, 3}, {0.3, 0.2, 0.1}, {0, -1, 0}, 1, 64, 48);
  json object = parse_json(format_camera(camera), "test");
  object["position"] = {10, 20, 30};
  object["cx"] = 10.5;
  const Camera edited = parse_camera(object.dump(), "test");
  EXPECT_LT(glm::distance(edited.position(), glm::dvec3(10, 20, 30)), 1e-9);
  EXPECT_EQ(edited.center_px.x, 10);
}

TEST(Cameras, wrong_and_missing_fields_are_named_with_file_and_camera) {
  const std::vector<std::pair<std::function<void(json&)>, std::string>> cases = {
      {[](json& c) { c.erase("position"); }, "position is missing"},
      {[](json& c) { c.erase("fx"); }, "fx is missing"},
      {[](json& c) { c["fy"] = "500"; }, "fy is not a number"},
      {[](json& c) { c["fx"] = -1; }, "fx is -1, but must be above 0"},
      {[](json& c) { c["width"] = 0; }, "width is 0, but must be a whole number"},
      {[](json& c) { c["height"] = 1e9; }, "height is 1000000000, but must be a whole number"},
      {[](json& c) { c["height"] = 2.5; }, "height is 2.5, but must be a whole number"},
      {[](json& c) {
         c["position"] = {1, 2};
       },
       "position is not a list of 3 numbers"},
      {[](json& c) { c["position"][1] = "x"; }, "position is not a number"},
      {[](json& c) { c["rotation"] = 5; }, "rotation is not a list of 3 rows"},
      {[](json& c) {
         c["rotation"][2] = {1, 2, 3, 4};
       },
       "rotation is not a list of 3 numbers"},
      {[](json& c) {
         c["rotation"][2] = {0, 0, -1};
       },
       "rotation is not a rotation matrix"},
      {[](json& c) {
         c["rotation"][2] = {0, 0, 2};
       },
       "rotation is not a rotation matrix"},
      {[](json& c) { c["img_name"] = 5; }, "img_name is not a string"},
      {[](json& c) { c["near"] = 0; }, "near is 0, but must be above 0"},
      {[](json& c) { c = json::array(); }, "not a JSON object"},
  };
  const TemporaryFolder folder;
  for (const auto& [damage, sentence] : cases) {
    json list = {valid_camera(), valid_camera()};
    damage(list[1]);
    std::ofstream(folder / "cameras.json") << list;
    const std::string message = error_of([&] { read_cameras(folder / "cameras.json"); });
    EXPECT_THAT(message, HasSubstr("cameras.json: camera 1: " + sentence));
  }
}

TEST(Cameras, what_single_precision_cannot_hold_is_refused) {
  const auto with = [](const char* position, const char* fx) {
    return fmt::format(R"({{"position":[0,{},0],"rotation":[[1,0,0],[0,1,0],[0,0,1]],)"
                       R"("fx":{},"fy":50,"width":64,"height":48}})",
                       position, fx);
  };
  EXPECT_EQ(error_of([&] { parse_camera(with("1e14", "1e14"), "x"); }), "no error");
  EXPECT_EQ(error_of([&] { parse_camera(with("-1e40", "50"), "x"); }),
            "x: its position -1e+40 is more than 1e+15 from the origin");
  EXPECT_THAT(error_of([&] { parse_camera(with("0", "1e40"), "x"); }),
              HasSubstr("x: 1e+40 for its focal length"));
  const TemporaryFolder folder;
  std::ofstream(folder / "cameras.json")
      << "[" << with("0", "50") << "," << with("1e40", "50") << "]";
  // One of several cameras is left out.
  const CameraSet set = read_camera_set(folder / "cameras.json");
  EXPECT_EQ(set.cameras.size(), 1u);
  EXPECT_THAT(set.sentences(),
              testing::ElementsAre(testing::AllOf(
                  HasSubstr("cameras.json: camera 1: its position 1e+40 is more than 1e+15"),
                  HasSubstr("; this camera is left out"))));
  std::ofstream(folder / "cameras.json") << "[" << with("1e40", "50") << "]";
  EXPECT_THAT(error_of([&] { read_cameras(folder / "cameras.json"); }),
              HasSubstr("cameras.json: camera 0: its position 1e+40"));
}

TEST(Cameras, hostile_json_is_an_error_in_one_sentence) {
  const std::string deep(100000, '[');
  EXPECT_THAT(error_of([&] { parse_camera(deep, "--camera-json"); }),
              HasSubstr("levels of brackets"));
  EXPECT_THAT(error_of([] { parse_camera("{\"fx\": 1e999}", "x"); }), HasSubstr("not valid JSON"));
  EXPECT_THAT(error_of([] { parse_camera("", "x"); }), HasSubstr("not valid JSON"));
  EXPECT_THAT(error_of([] { parse_camera("{\n\n\"fx\": }", "x"); }), HasSubstr("line 3"));
  EXPECT_THAT(error_of([] { parse_camera("[1]", "x"); }), HasSubstr("not a JSON object"));
  EXPECT_THAT(error_of([] { read_cameras("/nonexistent.json"); }),
              HasSubstr("/nonexistent.json: cannot be read"));
  const TemporaryFolder folder;
  std::ofstream(folder / "cameras.json") << "{}";
  EXPECT_THAT(error_of([&] { read_cameras(folder / "cameras.json"); }),
              HasSubstr("not a list of cameras"));
}

TEST(Cameras, are_found_up_to_three_folders_above_the_scene) {
  const TemporaryFolder folder;
  const auto iteration = folder / "model/point_cloud/iteration_7";
  std::filesystem::create_directories(iteration / "too/deep");
  std::ofstream(folder / "model/cameras.json") << "[]";
  std::ofstream(folder / "model/cfg_args") << "Namespace(sh_degree=3, white_background=True)";
  EXPECT_EQ(find_cameras_file(iteration / "point_cloud.ply"), folder / "model/cameras.json");
  EXPECT_TRUE(model_wants_white_background(iteration / "point_cloud.ply"));
  EXPECT_EQ(find_cameras_file(iteration / "too/deep/point_cloud.ply"), std::nullopt);
  EXPECT_FALSE(model_wants_white_background(iteration / "too/deep/point_cloud.ply"));
  std::ofstream(folder / "model/cfg_args") << "Namespace(white_background=False)";
  EXPECT_FALSE(model_wants_white_background(iteration / "point_cloud.ply"));
}

TEST(Cameras, the_trained_scene_s_file_is_read) {
  const std::filesystem::path path = test::shared_folder() / "scenes/plush/cameras.json";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const std::vector<Camera> cameras = read_cameras(path);
  ASSERT_EQ(cameras.size(), 97u);
  EXPECT_EQ(cameras[0].name, "20240212_003919");
  EXPECT_EQ(cameras[0].width, 1600);
  EXPECT_LT(glm::distance(cameras[0].position(), glm::dvec3(-2.02394106, 1.50942399, -3.17181061)),
            1e-6);
  for (const Camera& camera : cameras)
    expect_equal(parse_camera(format_camera(camera), "test"), camera);
}

}  // namespace
}  // namespace qs
