// SPDX-License-Identifier: MIT
// Undistorted photographs, compared with pictures whose value is known for every direction.
#include <cmath>

#include <gtest/gtest.h>

#include "io/camera/photographs.h"
#include "support/pool.h"

namespace qs {
namespace {

// A smooth scene infinitely far away.
float value_at(glm::dvec2 slope) {
  return static_cast<float>(0.5 + 0.25 * std::sin(7 * slope.x) + 0.2 * std::cos(9 * slope.y));
}

// The direction that a lens shows at a distorted direction, by fixed-point iteration.
glm::dvec2 inverse(const Lens& lens, glm::dvec2 distorted) {
  glm::dvec2 slope = distorted;
  for (int i = 0; i < 200; ++i) slope += distorted - lens.distort(slope);
  return slope;
}

TEST(Undistort, shows_every_direction_where_the_pinhole_camera_does) {
  const Lens lens{{160, 164}, {99, 72}, -0.12, 0.03, 0.004, -0.003};
  Camera size;
  size.width = 200;
  size.height = 150;
  const LensCamera camera = undistorted_camera(size, lens, "test");
  // A photograph of twice the camera's size.
  const LensCamera twice = camera.scaled(400, 300);
  Image photograph(400, 300, 3);
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < 400; ++x) {
      const glm::dvec2 d = (glm::dvec2(x, y) - twice.lens->center_px) / twice.lens->focal_px;
      for (int c = 0; c < 3; ++c)
        photograph.at(x, y, c) = value_at(inverse(lens, d)) + 0.1f * float(c);
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

}  // namespace
}  // namespace qs
