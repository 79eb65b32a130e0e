// SPDX-License-Identifier: MIT
#include "app/remote/sibr_message.h"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace qs {
namespace {

using Json = nlohmann::json;

Camera tilted_camera() {
  Camera camera = look_at({1, -2, 3}, {0.5, 0, 0}, {0, -1, 0.2}, 0.8, 800, 600);
  camera.focal_px.x *= 1.25;
  return camera;
}

Json request_json() {
  return {{"resolution_x", 8},
          {"resolution_y", 6},
          {"fov_x", 1.0},
          {"fov_y", 0.8},
          {"scaling_modifier", 0.5},
          {"view_matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.25, 0.5, -2, 1}}};
}

TEST(SibrMessage, the_camera_of_a_request_is_the_camera_that_it_was_made_of) {
  const Camera camera = tilted_camera();
  const std::string message = sibr_message(request_for(camera));
  const auto read = parse_sibr_request(message.substr(4));
  ASSERT_TRUE(read);
  const auto again = camera_of(*read);
  ASSERT_TRUE(again);
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 3; ++r)
      EXPECT_NEAR(again->view_from_world[c][r], camera.view_from_world[c][r], 1e-6);
  }
  EXPECT_NEAR(again->focal_px.x, camera.focal_px.x, 1e-4);
  EXPECT_NEAR(again->focal_px.y, camera.focal_px.y, 1e-4);
  EXPECT_EQ(again->center_px, camera.center_px);
}

TEST(SibrMessage, views_have_opengl_axes_in_requests) {
  const auto request = parse_sibr_request(request_json().dump());
  ASSERT_TRUE(request);
  const auto camera = camera_of(*request);
  ASSERT_TRUE(camera);
  // y up and z backward become y down and z forward.
  EXPECT_EQ(camera->view_from_world[0], glm::dvec3(1, 0, 0));
  EXPECT_EQ(camera->view_from_world[1], glm::dvec3(0, -1, 0));
  EXPECT_EQ(camera->view_from_world[2], glm::dvec3(0, 0, -1));
  EXPECT_EQ(camera->view_from_world[3], glm::dvec3(0.25, -0.5, 2));
  EXPECT_DOUBLE_EQ(camera->focal_px.x, 4 / std::tan(0.5));
  EXPECT_EQ(camera->center_px, glm::dvec2(3.5, 2.5));
  EXPECT_EQ(request->splat_scale, 0.5);
}

// As the rasterizer of the trainers reads it, after it has negated row 1.
TEST(SibrMessage, the_projection_puts_a_point_where_the_camera_sees_it) {
  const Camera camera = tilted_camera();
  const std::string message = sibr_message(request_for(camera));
  const Json json = Json::parse(message.substr(4));
  const glm::dvec3 point(0.3, 0.2, -0.1);
  glm::dvec4 clip(0.0);
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r)
      clip[r] +=
          json.at("view_projection_matrix").at(static_cast<std::size_t>(4 * c + r)).get<double>() *
          (c == 3 ? 1 : point[c]);
  }
  clip.y = -clip.y;
  const glm::dvec3 seen = camera.view_from_world * glm::dvec4(point, 1);
  EXPECT_NEAR(clip.w, seen.z, 1e-6);
  const auto pixel = [](double ndc, int side) { return ((ndc + 1) * side - 1) / 2; };
  EXPECT_NEAR(pixel(clip.x / clip.w, camera.width),
              camera.center_px.x + camera.focal_px.x * seen.x / seen.z, 1e-3);
  EXPECT_NEAR(pixel(clip.y / clip.w, camera.height),
              camera.center_px.y + camera.focal_px.y * seen.y / seen.z, 1e-3);
}

TEST(SibrMessage, a_request_fits_a_segment_with_its_length) {
  Camera camera = tilted_camera();
  camera.view_from_world[3] = {-123456.789012345, 0.000123456789012, -9876.54321098765};
  const std::string message = sibr_message(request_for(camera));
  EXPECT_LE(message.size(), 1400u);
  EXPECT_EQ(static_cast<std::uint8_t>(message[0]) + 256u * static_cast<std::uint8_t>(message[1]),
            message.size() - 4);
}

TEST(SibrMessage, a_request_has_all_values_that_trainers_read) {
  SibrRequest request = request_for(tilted_camera());
  request.trains = false;
  const Json json = Json::parse(sibr_message(request).substr(4));
  for (const char* name : {"shs_python", "rot_scale_python", "z_near", "z_far", "scaling_modifier",
                           "keep_alive", "render_mode"})
    EXPECT_TRUE(json.contains(name)) << name;
  EXPECT_EQ(json.at("train"), 0);
  EXPECT_EQ(json.at("view_matrix").size(), 16u);
}

TEST(SibrMessage, null_is_a_number_that_is_not_finite) {
  Json json = request_json();
  json["view_matrix"][5] = nullptr;
  auto request = parse_sibr_request(json.dump());
  ASSERT_TRUE(request);
  EXPECT_FALSE(camera_of(*request));
  json = request_json();
  json["fov_x"] = nullptr;
  request = parse_sibr_request(json.dump());
  ASSERT_TRUE(request);
  EXPECT_FALSE(camera_of(*request));
}

TEST(SibrMessage, without_a_picture_only_the_sides_are_read) {
  const auto request = parse_sibr_request(
      R"({"resolution_x":0,"resolution_y":7,"fov_x":null,"view_matrix":[null]})");
  ASSERT_TRUE(request);
  EXPECT_EQ(request->width, 0);
  EXPECT_FALSE(camera_of(*request));
}

TEST(SibrMessage, damaged_requests_are_refused) {
  EXPECT_FALSE(parse_sibr_request(""));
  EXPECT_FALSE(parse_sibr_request("[1,2]"));
  EXPECT_FALSE(parse_sibr_request(request_json().dump().substr(0, 100)));
  EXPECT_FALSE(parse_sibr_request(std::string(8000, '[')));
  const auto changed = [](const char* name, const Json& value) {
    Json json = request_json();
    json[name] = value;
    return parse_sibr_request(json.dump());
  };
  EXPECT_TRUE(changed("resolution_x", kMostSibrSide));
  EXPECT_FALSE(changed("resolution_x", kMostSibrSide + 1));
  EXPECT_FALSE(changed("resolution_y", -1));
  EXPECT_FALSE(changed("resolution_y", 1e300));
  EXPECT_FALSE(changed("resolution_y", "6"));
  EXPECT_FALSE(changed("fov_y", "wide"));
  EXPECT_FALSE(changed("view_matrix", Json::array({1, 2, 3})));
  for (const char* name : {"resolution_x", "fov_x", "fov_y", "scaling_modifier", "view_matrix"}) {
    Json json = request_json();
    json.erase(name);
    EXPECT_FALSE(parse_sibr_request(json.dump())) << name;
  }
}

TEST(SibrMessage, views_that_are_no_rotation_have_no_camera) {
  const auto camera_with = [](std::size_t place, double value) {
    Json json = request_json();
    json["view_matrix"][place] = value;
    return camera_of(*parse_sibr_request(json.dump()));
  };
  EXPECT_TRUE(camera_with(12, 3));
  EXPECT_FALSE(camera_with(0, 2));       // stretched
  EXPECT_FALSE(camera_with(0, -1));      // mirrored
  EXPECT_FALSE(camera_with(12, 1e300));  // absurd
  Json json = request_json();
  json["fov_x"] = 4;
  EXPECT_FALSE(camera_of(*parse_sibr_request(json.dump())));
}

TEST(SibrMessage, what_a_trainer_says_first_is_a_list_of_names) {
  const auto names = parse_render_modes(R"(["RGB","Normal"])");
  ASSERT_TRUE(names);
  EXPECT_EQ(names->size(), 2u);
  EXPECT_FALSE(parse_render_modes("[1]"));
  EXPECT_FALSE(parse_render_modes("{}"));
  EXPECT_FALSE(parse_render_modes("\x01\x02"));
}

TEST(SibrMessage, metrics_may_lack_numbers) {
  const SibrMetrics metrics = parse_metrics(R"({"#":1200,"loss":0.04,"more":[]})");
  EXPECT_EQ(metrics.gaussians, 1200);
  EXPECT_EQ(metrics.loss, 0.04);
  EXPECT_FALSE(parse_metrics(R"({"loss":"low"})").loss);
  EXPECT_FALSE(parse_metrics("none").gaussians);
}

}  // namespace
}  // namespace qs
