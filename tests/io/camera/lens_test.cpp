// SPDX-License-Identifier: MIT
// Lenses that distort, and the pinhole cameras that replace them, from every format.
#include "io/camera/lens.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/camera/cameras.h"
#include "io/camera/lens_views.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::HasSubstr;

// A lens of 100 x 75 pixels.
Lens phone(double k1, double k2 = 0, double p1 = 0, double p2 = 0, double focal = 80) {
  const Lens lens{
      find_lens_model("OPENCV"), {100, 75}, {focal, focal * 82 / 80}, {49, 36}, {k1, k2, p1, p2}};
  return checked_lens(lens, "test");
}

// The slope that the lens shows at the distorted slope.
glm::dvec2 distorted(const Lens& lens, glm::dvec2 slope) {
  return (lens.project({slope, 1}).value() - lens.center_px) / lens.focal_px;
}

TEST(Lens, distorts_as_colmap_states_the_model_opencv) {
  // By the text of COLMAP's documentation, written with the powers of u and v.
  const double u = 0.3, v = -0.4, k1 = -0.2, k2 = 0.07, p1 = 0.01, p2 = -0.02;
  const glm::dvec2 d = distorted(phone(k1, k2, p1, p2), {u, v});
  const double u2 = 0.09, v2 = 0.16, uv = -0.12, r2 = 0.25;
  EXPECT_NEAR(d.x, u + u * (k1 * r2 + k2 * r2 * r2) + 2 * p1 * uv + p2 * (r2 + 2 * u2), 1e-14);
  EXPECT_NEAR(d.y, v + v * (k1 * r2 + k2 * r2 * r2) + 2 * p2 * uv + p1 * (r2 + 2 * v2), 1e-14);
}

TEST(Lens, every_pixel_of_the_undistorted_photograph_lies_in_the_photograph_and_some_at_its_edge) {
  for (const Lens& lens : {phone(-0.1), phone(0.1), phone(-0.05, 0.02, 0.003, -0.002)}) {
    const Camera camera = undistorted_camera(lens, "test").camera;
    EXPECT_DOUBLE_EQ(camera.focal_px.x / 80, camera.focal_px.y / 82);
    EXPECT_EQ(camera.center_px, lens.center_px);
    double least = 1e9;  // distance from the photograph's edge, outside < 0
    for (double y = -0.5; y <= 74.5; y += 0.25) {
      for (double x = -0.5; x <= 99.5; x += 0.25) {
        const glm::dvec2 slope = (glm::dvec2(x, y) - camera.center_px) / camera.focal_px;
        const glm::dvec2 at = lens.project({slope, 1}).value();
        least = std::min({least, at.x + 0.5, at.y + 0.5, 99.5 - at.x, 74.5 - at.y});
      }
    }
    EXPECT_NEAR(least, 0, 0.01);
  }
  EXPECT_LT(undistorted_camera(phone(-0.1), "test").camera.focal_px.x, 80)
      << "a barrel shows more than a pinhole camera";
  EXPECT_GT(undistorted_camera(phone(0.1), "test").camera.focal_px.x, 80);
}

TEST(Lens, that_folds_inside_the_photograph_keeps_the_face_that_it_shows) {
  const Lens folds = phone(-0.5, 0, 0, 0, 28);  // at 39 degrees, 15 px from the middle
  const LensCamera camera = undistorted_camera(folds, "here");
  EXPECT_EQ(camera.lens->face, kAllFaces);
  const std::vector<LensCamera> views = views_of(camera);
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(views[0].lens->face, "front");
  // It folds at 1 / sqrt(1.5), which it shows at 2/3 of that: an ellipse.
  const double radius = 2.0 / 3 / std::sqrt(1.5);
  EXPECT_NEAR(used_share(camera), 3.1416 * (28 * radius) * (28.7 * radius) / 7500, 0.003);
  EXPECT_THAT(test::error_of([] { undistorted_camera(phone(-200), "here"); }),
              HasSubstr("here: the lens distorts too strongly: its photograph shows less than a "
                        "tenth of every face"));
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
  EXPECT_EQ(expected[0].lens->coefficients[1], 0.02);
  std::ofstream(folder / "cameras.json") << format_cameras(expected);
  for (const char* name : {"opencv", "transforms.json", "cameras.json"}) {
    const auto cameras = read_camera_set(folder / name).cameras;
    ASSERT_EQ(cameras.size(), 1u) << name;
    ASSERT_TRUE(cameras[0].lens) << name;
    EXPECT_EQ(cameras[0].lens->focal_px, expected[0].lens->focal_px) << name;
    EXPECT_EQ(cameras[0].lens->center_px, expected[0].lens->center_px) << name;
    EXPECT_EQ(cameras[0].lens->coefficients[0], -0.1) << name;
    EXPECT_EQ(cameras[0].lens->coefficients[1], 0.02) << name;
    EXPECT_EQ(cameras[0].lens->limit, expected[0].lens->limit) << name;
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
  EXPECT_EQ(cameras[0].lens->model->name, "SIMPLE_RADIAL");
  EXPECT_EQ(cameras[0].lens->coefficients[0], 0.05);
  EXPECT_EQ(cameras[0].lens->focal_px, glm::dvec2(80));
}

// A camera of one model of COLMAP, with the parameters after the size.
LensCamera colmap_camera_of(const std::string& lens) {
  const TemporaryFolder folder;
  std::ofstream(folder / "cameras.txt") << "1 " << lens << "\n";
  std::ofstream(folder / "images.txt") << "1 1 0 0 0 0 0 0 1 a.jpg\n\n";
  return read_camera_set(folder.path()).cameras.at(0);
}

TEST(Lens, of_any_model_becomes_one_pinhole_camera_or_faces) {
  struct Row {
    const char* lens;
    std::vector<std::string> names;
    double used;  // from tests/golden/lenses.py
  };
  const std::vector<std::string> ahead = {"a_front", "a_right", "a_left", "a_up", "a_down"};
  const std::vector<std::string> all = {"a_front", "a_right", "a_back", "a_left", "a_up", "a_down"};
  const Row rows[] = {
      {"SIMPLE_FISHEYE 100 75 80 50 37.5", {"a"}, 0.899},
      {"OPENCV_FISHEYE 100 75 80 81 50 37.5 0.01 0 0 0", {"a"}, 0.900},
      {"FOV 100 75 80 81 50 37.5 0.9", {"a"}, 0.914},
      {"DIVISION 100 75 80 81 50 37.5 -0.1", {"a"}, 0.965},
      {"EUCM 100 75 80 81 50 37.5 0.6 1.1", {"a"}, 0.899},
      {"FULL_OPENCV 100 75 80 81 50 37.5 -0.1 0 0 0 0 0 0 0.01", {"a"}, 0.959},
      {"RAD_TAN_THIN_PRISM_FISHEYE 100 75 80 81 50 37.5 0.01 0 0 0 0 0 0 0 0.001 0 0 0",
       {"a"},
       0.900},
      // 180 degrees across a circle of 100 pixels in a square
      {"SIMPLE_FISHEYE 100 100 31.83 50 50", ahead, 1},
      {"OPENCV_FISHEYE 100 100 31.83 31.83 50 50 0 0 0 0", ahead, 1},
      {"THIN_PRISM_FISHEYE 100 100 31.83 31.83 50 50 0 0 0 0 0 0 0 0", ahead, 1},
      {"EQUIRECTANGULAR 200 100 200 100", all, 1},
      // 360 degrees across a circle in a square: the corners show nothing
      {"SIMPLE_FISHEYE 200 200 31.83 100 100", all, 0.785},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.lens);
    const LensCamera camera = colmap_camera_of(row.lens);
    std::vector<std::string> names;
    for (const LensCamera& view : views_of(camera)) {
      names.push_back(view.camera.name);
      EXPECT_EQ(view.photograph, "a.jpg");
    }
    EXPECT_EQ(names, row.names);
    EXPECT_NEAR(used_share(camera), row.used, 0.005);
  }
}

TEST(Lens, of_faces_stay_together_if_names_of_other_photographs_fall_between_theirs) {
  std::vector<LensCamera> cameras;
  for (const char* name : {"a_c", "b", "a"}) {
    LensCamera camera = colmap_camera_of("SIMPLE_FISHEYE 100 100 31.83 50 50");
    camera.camera.name = camera.photograph = name;
    for (const LensCamera& view : views_of(camera)) cameras.push_back(view);
  }
  std::ranges::reverse(cameras);
  sort_by_name(cameras);
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < cameras.size(); ++i)
    if (!is_next_face(cameras, i)) first.push_back(i);
  EXPECT_THAT(first, testing::ElementsAre(0, 5, 10));
  EXPECT_EQ(cameras[5].photograph, "a_c");
}

TEST(LensFaces, are_as_fine_as_the_photograph_and_not_as_its_formula_beyond_it) {
  // 130 degrees wide. At 180 degrees from the axis the formula grows 5 times as fast.
  const auto views =
      views_of(colmap_camera_of("OPENCV_FISHEYE 188 141 82.79 82.79 94 70.5 0.02 -0.005 0.001 0"));
  ASSERT_GT(views.size(), 1u);
  for (const LensCamera& view : views) {
    EXPECT_GE(view.camera.focal_px.x, 82.79);
    EXPECT_LE(view.camera.focal_px.x, 1.2 * 82.79);
  }
}

TEST(Lens, of_a_face_survives_cameras_json) {
  const TemporaryFolder folder;
  const std::vector<LensCamera> views =
      views_of(colmap_camera_of("OPENCV_FISHEYE 100 100 32 33 50 49 0.01 0 0.002 0"));
  ASSERT_GT(views.size(), 1u);
  std::ofstream(folder / "cameras.json") << format_cameras(views);
  const std::vector<LensCamera> read = read_camera_set(folder / "cameras.json").cameras;
  ASSERT_EQ(read.size(), views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(views_of(read[i]).size(), 1u);
    EXPECT_EQ(read[i].photograph, "a.jpg");
    EXPECT_EQ(read[i].camera.view_from_world, views[i].camera.view_from_world);
    EXPECT_EQ(read[i].lens->face, views[i].lens->face);
    EXPECT_EQ(read[i].lens->size_px, views[i].lens->size_px);
    EXPECT_EQ(read[i].lens->coefficients, views[i].lens->coefficients);
    EXPECT_EQ(read[i].source_of({3, 4}), views[i].source_of({3, 4}));
  }
}

TEST(Lens, has_a_text_that_is_read_as_the_same_lens) {
  for (const char* words :
       {"SIMPLE_FISHEYE,60,40,19.25,30,20.5", "EQUIRECTANGULAR,128,64",
        "EUCM,60,60,20,21,30,29,0.6,1.1",
        "OPENCV_FISHEYE,64,48,30.123456789012,31,32,24,0.01,-0.002,0,1e-07",
        "RAD_TAN_THIN_PRISM_FISHEYE,64,48,30,31,32,24,0.01,0.02,0.03,0,0,0,0.001,0.002,0,0,0,0.5",
        "METASHAPE,64,32,40,41,32,16,0.05,-0.02,0.004,-0.001,0.002,-0.003,0.006"})
    EXPECT_EQ(photograph_view(parse_lens(words, "test")).text, words);
}

}  // namespace
}  // namespace qs
