// SPDX-License-Identifier: MIT
// Lenses that distort, and the pinhole cameras that replace them, from every format.
#include "io/camera/lens.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/camera/cameras.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::HasSubstr;

Lens phone(double k1, double k2 = 0, double p1 = 0, double p2 = 0) {
  return {{80, 82}, {49, 36}, k1, k2, p1, p2};
}

Camera size_of_100_by_75() {
  Camera camera;
  camera.width = 100;
  camera.height = 75;
  return camera;
}

TEST(Lens, distorts_as_colmap_states_the_model_opencv) {
  // By the text of COLMAP's documentation, written with the powers of u and v.
  const double u = 0.3, v = -0.4, k1 = -0.2, k2 = 0.07, p1 = 0.01, p2 = -0.02;
  const glm::dvec2 d = phone(k1, k2, p1, p2).distort({u, v});
  const double u2 = 0.09, v2 = 0.16, uv = -0.12, r2 = 0.25;
  EXPECT_NEAR(d.x, u + u * (k1 * r2 + k2 * r2 * r2) + 2 * p1 * uv + p2 * (r2 + 2 * u2), 1e-15);
  EXPECT_NEAR(d.y, v + v * (k1 * r2 + k2 * r2 * r2) + 2 * p2 * uv + p1 * (r2 + 2 * v2), 1e-15);
}

TEST(Lens, every_pixel_of_the_undistorted_photograph_lies_in_the_photograph_and_some_at_its_edge) {
  for (const Lens& lens : {phone(-0.1), phone(0.1), phone(-0.05, 0.02, 0.003, -0.002)}) {
    const Camera camera = undistorted_camera(size_of_100_by_75(), lens, "test").camera;
    EXPECT_DOUBLE_EQ(camera.focal_px.x / 80, camera.focal_px.y / 82);
    EXPECT_EQ(camera.center_px, lens.center_px);
    double least = 1e9;  // distance from the photograph's edge, outside < 0
    for (double y = -0.5; y <= 74.5; y += 0.25) {
      for (double x = -0.5; x <= 99.5; x += 0.25) {
        const glm::dvec2 slope = (glm::dvec2(x, y) - camera.center_px) / camera.focal_px;
        const glm::dvec2 at = lens.focal_px * lens.distort(slope) + lens.center_px;
        least = std::min({least, at.x + 0.5, at.y + 0.5, 99.5 - at.x, 74.5 - at.y});
      }
    }
    EXPECT_NEAR(least, 0, 0.01);
  }
  EXPECT_LT(undistorted_camera(size_of_100_by_75(), phone(-0.1), "test").camera.focal_px.x, 80)
      << "a barrel shows more than a pinhole camera";
  EXPECT_GT(undistorted_camera(size_of_100_by_75(), phone(0.1), "test").camera.focal_px.x, 80);
}

TEST(Lens, that_shows_a_direction_twice_is_refused) {
  EXPECT_THAT(test::error_of([] {
                undistorted_camera(size_of_100_by_75(), {{8, 8}, {49, 36}, -0.5, 0, 0, 0}, "here");
              }),
              HasSubstr("here: the lens distorts too strongly; undistort the photographs first"));
}

TEST(Lens, of_colmap_and_transforms_json_are_the_same_and_survive_cameras_json) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "radial");
  std::filesystem::create_directories(folder / "opencv");
  const std::string image = "1 1 0 0 0 0 0 0 1 a.jpg\n\n";
  std::ofstream(folder / "radial/cameras.txt") << "1 RADIAL 100 75 80 49.5 36.5 -0.1 0.02\n";
  std::ofstream(folder / "opencv/cameras.txt") << "1 OPENCV 100 75 80 80 49.5 36.5 -0.1 0.02 0 0\n";
  for (const char* name : {"radial", "opencv"})
    std::ofstream(folder / name / "images.txt") << image;
  std::ofstream(folder / "transforms.json")
      << R"({"w": 100, "h": 75, "fl_x": 80, "fl_y": 80, "cx": 49.5, "cy": 36.5, "k1": -0.1,
             "k2": 0.02, "frames": [{"file_path": "a.jpg", "transform_matrix":
             [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]}]})";
  const auto expected = read_camera_set(folder / "radial").cameras;
  ASSERT_TRUE(expected[0].lens);
  EXPECT_EQ(expected[0].lens->k2, 0.02);
  std::ofstream(folder / "cameras.json") << format_cameras(expected);
  for (const char* name : {"opencv", "transforms.json", "cameras.json"}) {
    const auto cameras = read_camera_set(folder / name).cameras;
    ASSERT_EQ(cameras.size(), 1u) << name;
    ASSERT_TRUE(cameras[0].lens) << name;
    EXPECT_EQ(cameras[0].lens->focal_px, expected[0].lens->focal_px) << name;
    EXPECT_EQ(cameras[0].lens->center_px, expected[0].lens->center_px) << name;
    EXPECT_EQ(cameras[0].lens->k1, -0.1) << name;
    EXPECT_EQ(cameras[0].lens->k2, 0.02) << name;
    EXPECT_EQ(cameras[0].camera.focal_px, expected[0].camera.focal_px) << name;
    EXPECT_EQ(cameras[0].camera.view_from_world, expected[0].camera.view_from_world) << name;
  }
  std::ofstream(folder / "cameras.json") << R"([{"lens": 5}])";
  EXPECT_NE(test::error_of([&] { read_camera_set(folder / "cameras.json"); }), "");
}

TEST(Lens, of_model_simple_radial_has_one_coefficient) {
  const TemporaryFolder folder;
  std::ofstream(folder / "cameras.txt") << "1 SIMPLE_RADIAL 100 75 80 50 37 0.05\n";
  std::ofstream(folder / "images.txt") << "1 1 0 0 0 0 0 0 1 a.jpg\n\n";
  const auto cameras = read_camera_set(folder.path()).cameras;
  ASSERT_TRUE(cameras[0].lens);
  EXPECT_EQ(cameras[0].lens->k1, 0.05);
  EXPECT_EQ(cameras[0].lens->k2, 0);
  EXPECT_EQ(cameras[0].lens->focal_px, glm::dvec2(80));
}

}  // namespace
}  // namespace qs
