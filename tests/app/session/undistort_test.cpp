// SPDX-License-Identifier: MIT
// Undistorted photographs, compared with pictures whose value is known for every direction.
#include <algorithm>
#include <cmath>
#include <fstream>

#include <glm/common.hpp>
#include <gtest/gtest.h>

#include "app/session/placed_cameras.h"
#include "io/camera/photographs.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

// A smooth scene infinitely far away.
float value_at(glm::dvec2 slope) {
  return static_cast<float>(0.5 + 0.25 * std::sin(7 * slope.x) + 0.2 * std::cos(9 * slope.y));
}

TEST(Undistort, shows_every_direction_where_the_pinhole_camera_does) {
  const Lens lens = checked_lens(
      {find_lens_model("OPENCV"), {200, 150}, {160, 164}, {99, 72}, {-0.12, 0.03, 0.004, -0.003}},
      "test");
  const LensCamera camera = undistorted_camera(lens, "test");
  // A photograph of twice the camera's size.
  const LensCamera twice = camera.scaled(400, 300);
  Image photograph(400, 300, 3);
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < 400; ++x) {
      const glm::dvec3 seen = twice.lens->direction({x, y}).value();
      for (int c = 0; c < 3; ++c)
        photograph.at(x, y, c) = value_at(glm::dvec2(seen) / seen.z) + 0.1f * float(c);
    }
  }
  const Image image = undistorted(photograph, camera, test::pool());
  double largest = 0, moved = 0;
  for (int y = 2; y < 298; ++y) {
    for (int x = 2; x < 398; ++x) {
      const glm::dvec2 slope = (glm::dvec2(x, y) - twice.camera.center_px) / twice.camera.focal_px;
      for (int c = 0; c < 3; ++c) {
        const float expected = value_at(slope) + 0.1f * float(c);
        largest = std::max(largest, std::abs(double(image.at(x, y, c) - expected)));
        moved = std::max(moved, std::abs(double(photograph.at(x, y, c) - expected)));
      }
    }
  }
  EXPECT_LT(largest, 2e-4) << "bilinear interpolation of this picture";
  EXPECT_GT(moved, 0.05) << "without it the picture is wrong";
}

TEST(Undistort, leaves_photographs_of_pinhole_cameras_alone) {
  Image photograph(3, 2, 1);
  photograph.values = {1, 2, 3, 4, 5, 6};
  EXPECT_EQ(undistorted(photograph, {}, test::pool()).values, photograph.values);
}

// A smooth value for every direction, up to 1.
float value_around(glm::dvec3 direction) {
  const glm::dvec3 d = glm::normalize(direction);
  return static_cast<float>(0.5 + 0.2 * std::sin(3 * d.x) + 0.15 * std::cos(4 * d.y) +
                            0.1 * std::sin(5 * d.z));
}

TEST(Undistort, divides_wide_photographs_into_faces_with_masks) {
  struct Row {
    Lens lens;
    std::size_t faces;
    double counted;  // share of all pixels of the faces, from tests/golden/lenses.py
  };
  const Row rows[] = {
      {{find_lens_model("EQUIRECTANGULAR"), {600, 300}}, 6, 1},
      {{find_lens_model("FISHEYE"), {400, 400}, {127.3, 127.3}, {199.5, 199.5}}, 5, 0.727},
      {{find_lens_model("OPENCV_FISHEYE"),
        {400, 400},
        {125, 127},
        {198, 201},
        {0.02, -0.005, 0.001, -0.0002}},
       5,
       0.728},
      {{find_lens_model("EUCM"), {400, 300}, {120, 121}, {199, 150}, {0.6, 1.1}}, 5, 0.623},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.lens.model->name);
    const LensCamera camera = lens_camera(row.lens, "test");
    const Lens& lens = *camera.lens;
    const auto sides = glm::ivec2(lens.size_px);
    Image photograph(sides.x, sides.y, 1);
    for (int y = 0; y < sides.y; ++y)
      for (int x = 0; x < sides.x; ++x)
        if (const auto seen = lens.direction({x, y})) photograph.at(x, y, 0) = value_around(*seen);
    const std::vector<LensCamera> views = views_of(camera);
    EXPECT_EQ(views.size(), row.faces);
    double counted = 0, all = 0, largest = 0;
    for (const LensCamera& view : views) {
      const Image image = undistorted(photograph, view, test::pool());
      ASSERT_EQ(image.width, view.camera.width);
      const auto mask = lens_mask(view, image.width, image.height, test::pool());
      for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
          ++all;
          if (!mask.empty() && mask[static_cast<std::size_t>(y * image.width + x)] == 0) continue;
          ++counted;
          // The face's axes in the world: the lens is not turned.
          const glm::dvec2 slope =
              (glm::dvec2(x, y) - view.camera.center_px) / view.camera.focal_px;
          const glm::dvec3 world =
              glm::transpose(glm::dmat3(view.camera.view_from_world)) * glm::dvec3(slope, 1);
          largest = std::max(largest, std::abs(double(image.at(x, y, 0)) - value_around(world)));
        }
      }
    }
    // Without the row beyond a pole of the panorama it is 2.6e-3 (the pole has the value of the
    // first row then), and with pixels at the photograph's edge 1.0e-3: a calculation in Python.
    EXPECT_LT(largest, 5e-4);
    EXPECT_NEAR(counted / all, row.counted, 0.001);
  }
}

// The weight of a pixel at this distance, as Catmull and Rom's cubics are usually written.
double catmull_rom(double distance) {
  const double t = std::abs(distance);
  if (t >= 2) return 0;
  return t < 1 ? 1.5 * t * t * t - 2.5 * t * t + 1 : -0.5 * t * t * t + 2.5 * t * t - 4 * t + 2;
}

TEST(Undistort, interpolates_faces_by_cubics_and_single_photographs_linearly) {
  struct Row {
    Lens lens;
    double reach;  // pixels
  };
  const Row rows[] = {
      {{find_lens_model("FISHEYE"), {40, 40}, {12.7, 12.9}, {19.5, 19.5}}, 2},
      {{find_lens_model("EQUIRECTANGULAR"), {80, 40}}, 2},
      {{find_lens_model("FISHEYE"), {40, 40}, {80, 81}, {19.5, 19.5}}, 1},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.lens.model->name);
    const LensCamera view = views_of(lens_camera(row.lens, "test"))[0];
    const glm::dvec2 bright = view.lens->center_px + 0.5 + glm::dvec2(2, -3);
    Image photograph(int(row.lens.size_px.x), int(row.lens.size_px.y), 1);
    photograph.at(int(bright.x), int(bright.y), 0) = 1;
    const Image image = undistorted(photograph, view, test::pool());
    int reached = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const auto source = view.source_of({x, y});
        if (!source) continue;
        const glm::dvec2 away = glm::abs(*source - glm::floor(bright));
        const double linear = std::max(0.0, 1 - away.x) * std::max(0.0, 1 - away.y);
        EXPECT_NEAR(image.at(x, y, 0),
                    row.reach == 2 ? catmull_rom(away.x) * catmull_rom(away.y) : linear, 1e-5);
        reached += away.x < row.reach && away.y < row.reach ? 1 : 0;
      }
    }
    EXPECT_GE(reached, 4);
  }
}

TEST(Undistort, counts_only_pixels_whose_middle_is_shown) {
  // Straight back is shown on a circle, of which only a part is in the photograph.
  const Lens lens{
      find_lens_model("SIMPLE_RADIAL_FISHEYE"), {40, 30}, {0.7, 0.714}, {19.5, 14.5}, {0.9}};
  Image photograph(40, 30, 1);
  std::ranges::fill(photograph.values, 1.0f);
  for (const LensCamera& view : views_of(lens_camera(lens, "test"))) {
    SCOPED_TRACE(view.lens->face);
    const Image image = undistorted(photograph, view, test::pool());
    const auto mask = lens_mask(view, image.width, image.height, test::pool());
    for (std::size_t i = 0; i < image.values.size(); ++i)
      if (mask.empty() || mask[i] == 1) {
        EXPECT_NEAR(image.values[i], 1, 1e-5) << i;
      }
  }
}

TEST(Undistort, averages_the_pixels_of_a_panorama_at_its_poles) {
  // Columns alternate between 0 and 1, and rows next to the poles cover many of them.
  Image stripes(600, 300, 1);
  for (int y = 0; y < 300; ++y)
    for (int x = 1; x < 600; x += 2) stripes.at(x, y, 0) = 1;
  const Lens lens{find_lens_model("EQUIRECTANGULAR"), {600, 300}};
  for (const LensCamera& view : views_of(lens_camera(lens, "test"))) {
    if (view.lens->face != "up" && view.lens->face != "down") continue;
    SCOPED_TRACE(view.lens->face);
    const Image image = undistorted(stripes, view, test::pool());
    const int middle = image.width / 2;
    for (int y = middle - 12; y < middle + 12; ++y)
      for (int x = middle - 12; x < middle + 12; ++x)
        EXPECT_NEAR(image.at(x, y, 0), 0.5, 0.12) << x << ", " << y;
  }
}

TEST(Undistort, a_command_without_photographs_names_the_front_faces_that_it_uses) {
  const TemporaryFolder folder;
  std::ofstream(folder / "cameras.txt") << "1 SIMPLE_FISHEYE 60 60 19.1 30 30\n"
                                           "2 SIMPLE_FISHEYE 60 60 99 30 30\n";
  std::ofstream(folder / "images.txt") << "1 1 0 0 0 0 0 3 1 a.png\n\n2 1 0 0 0 0 0 3 2 b.png\n\n";
  Scene scene;
  scene.cloud = test::random_cloud(100, 0, 5);
  const PlacedCameras placed = placed_cameras(folder / "images.txt", scene, true);
  EXPECT_EQ(placed.cameras.size(), 2u);
  ASSERT_EQ(placed.warnings.size(), 1u);
  EXPECT_EQ(test::without_folder(placed.warnings[0], folder.path()),
            "images.txt: 1 of 2 cameras have lenses too wide for a pinhole camera: their front "
            "faces are used, but for render --camera-index N (the lens of the first: --lens "
            "SIMPLE_FISHEYE,60,60,19.1,30,30)");
}

}  // namespace
}  // namespace qs
