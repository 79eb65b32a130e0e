// SPDX-License-Identifier: MIT
// The models of lenses against golden points, which were computed from the formulas with numpy.
#include "io/camera/lens_models.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/camera/lens.h"
#include "support/error_of.h"

namespace qs {
namespace {

using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

// Focal lengths 500 and 510 or 500, principal point 320, 240 from pixel corners.
Lens lens_of(std::string_view name, const std::vector<double>& coefficients) {
  Lens lens{find_lens_model(name), {640, 480}, {500, 510}, {319.5, 239.5}};
  if (lens.model->focal_lengths == 1) lens.focal_px.y = 500;
  if (lens.model->focal_lengths == 0) lens.size_px = {1000, 500};
  std::ranges::copy(coefficients, lens.coefficients.begin());
  return checked_lens(lens, "here");
}

struct Golden {
  const char* model;
  std::vector<double> coefficients;
  glm::dvec2 a, b, c;  // COLMAP's pixels
};

constexpr double kGolden1 = 0.05, kGolden2 = -0.02, kGolden3 = 0.004, kGolden4 = -0.001,
                 kTangential1 = 0.002, kTangential2 = -0.003;

// The SIMPLE_ forms have 500 / 510 of y - 240.
glm::dvec2 simple(glm::dvec2 pixel) { return {pixel.x, 240 + (pixel.y - 240) * 500 / 510}; }

std::vector<Golden> golden_points() {
  const glm::dvec2 pinhole[] = {{470, 138}, {-30, 495}, {370, 546}};
  const glm::dvec2 division[] = {{468.099, 139.293}, {-7.344, 478.494}, {368.275, 535.446}};
  const glm::dvec2 fisheye[] = {{463.964, 142.104}, {30.960, 450.586}, {364.921, 514.914}};
  const glm::dvec2 rad_tan[] = {{465.299, 141.011}, {27.167, 452.576}, {365.820, 516.977}};
  const std::vector<double> aria = {kGolden1,     kGolden2,     kGolden3, kGolden4, 0.0005, -0.0002,
                                    kTangential1, kTangential2, 0.001,    -0.0005,  -0.002, 0.0003};
  const glm::dvec2 panorama[] = {{546.387, 219.876}, {402.800, 311.874}, {515.863, 335.662}};
  return {
      {"SIMPLE_PINHOLE", {}, simple(pinhole[0]), simple(pinhole[1]), simple(pinhole[2])},
      {"PINHOLE", {}, pinhole[0], pinhole[1], pinhole[2]},
      {"SIMPLE_RADIAL", {kGolden1}, {470.975, 139.350}, {-42.950, 499.250}, {370.925, 545.550}},
      {"RADIAL", {kGolden1, kGolden2}, {470.924, 139.384}, {-39.117, 496.512}, {370.788, 544.729}},
      {"OPENCV",
       {kGolden1, kGolden2, kTangential1, kTangential2},
       {470.339, 137.769},
       {-42.397, 503.978},
       {370.323, 551.751}},
      {"OPENCV_FISHEYE",
       {kGolden1, kGolden2, kGolden3, kGolden4},
       {464.786, 141.546},
       {25.009, 454.922},
       {365.516, 518.556}},
      {"FULL_OPENCV",
       {kGolden1, kGolden2, kTangential1, kTangential2, kGolden3, 0.01, 0.02, -0.003},
       {470.095, 137.936},
       {-36.904, 499.976},
       {370.016, 549.871}},
      {"FOV", {0.9}, {474.942, 134.639}, {6.529, 468.386}, {368.525, 536.972}},
      {"SIMPLE_RADIAL_FISHEYE",
       {kGolden1},
       {464.826, 143.449},
       {23.666, 451.667},
       {365.591, 513.548}},
      {"RADIAL_FISHEYE",
       {kGolden1, kGolden2},
       {464.785, 143.477},
       {25.139, 450.615},
       {365.511, 513.067}},
      {"THIN_PRISM_FISHEYE",
       {kGolden1, kGolden2, kTangential1, kTangential2, kGolden3, kGolden4, 0.001, -0.002},
       {464.307, 141.790},
       {23.024, 456.000},
       {365.290, 519.000}},
      {"RAD_TAN_THIN_PRISM_FISHEYE", aria, rad_tan[0], rad_tan[1], rad_tan[2]},
      // The formula of Project Aria's documentation gives the same: tests/golden/lenses.py.
      {"FISHEYE624", aria, rad_tan[0], rad_tan[1], rad_tan[2]},
      {"SIMPLE_DIVISION", {-0.1}, simple(division[0]), simple(division[1]), simple(division[2])},
      {"DIVISION", {-0.1}, division[0], division[1], division[2]},
      {"SIMPLE_FISHEYE", {}, simple(fisheye[0]), simple(fisheye[1]), simple(fisheye[2])},
      {"FISHEYE", {}, fisheye[0], fisheye[1], fisheye[2]},
      {"EUCM", {0.6, 1.1}, {464.028, 142.061}, {30.291, 451.074}, {364.976, 515.254}},
      {"EQUIRECTANGULAR", {}, panorama[0], panorama[1], panorama[2]},
      {"SPHERICAL", {}, panorama[0], panorama[1], panorama[2]},
      {"BROWN_CONRADY",
       {kGolden1, kGolden2, kGolden3, kTangential1, kTangential2},
       {470.341, 139.773},
       {-42.964, 499.207},
       {370.333, 545.699}},
      // From tests/golden/lenses.py: f = 510, b1 = -10, b2 = 3, and Metashape's order of p1 and p2.
      {"METASHAPE",
       {kGolden1, kGolden2, kGolden3, kGolden4, kTangential1, kTangential2, 3.0 / 500},
       {470.809, 136.927},
       {-35.283, 499.368},
       {372.827, 549.334}},
      {"METASHAPE_FISHEYE",
       {kGolden1, kGolden2, kGolden3, kGolden4, kTangential1, kTangential2, 3.0 / 500},
       {464.656, 141.137},
       {28.152, 453.141},
       {367.316, 517.309}},
  };
}

double angle_between(glm::dvec3 a, glm::dvec3 b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

TEST(LensModels, show_golden_directions_at_golden_points_and_find_them_again) {
  const glm::dvec3 rays[] = {{0.3, -0.2, 1}, {-0.7, 0.5, 1}, {0.1, 0.6, 1}};
  const std::vector<Golden> rows = golden_points();
  EXPECT_EQ(rows.size(), lens_models().size()) << "every model has a row";
  for (const Golden& row : rows) {
    SCOPED_TRACE(row.model);
    const Lens lens = lens_of(row.model, row.coefficients);
    const glm::dvec2 points[] = {row.a, row.b, row.c};
    for (int i = 0; i < 3; ++i) {
      const auto pixel = lens.project(rays[i]);
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->x + 0.5, points[i].x, 6e-4);
      EXPECT_NEAR(pixel->y + 0.5, points[i].y, 6e-4);
      const auto back = lens.direction(*pixel);
      ASSERT_TRUE(back);
      EXPECT_LT(angle_between(*back, rays[i]), 1e-9);
    }
  }
}

TEST(LensModels, show_directions_behind_the_eye) {
  const auto behind = lens_of("EQUIRECTANGULAR", {}).project({-0.5, 0.3, -1});
  ASSERT_TRUE(behind);
  EXPECT_NEAR(behind->x + 0.5, 73.792, 6e-4);
  EXPECT_NEAR(behind->y + 0.5, 291.723, 6e-4);
  const auto beside =
      lens_of("OPENCV_FISHEYE", {kGolden1, kGolden2, kGolden3, kGolden4}).project({1, 0.5, -0.2});
  ASSERT_TRUE(beside);
  EXPECT_NEAR(beside->x + 0.5, 1096.208, 6e-4);
  EXPECT_NEAR(beside->y + 0.5, 635.866, 6e-4);
}

TEST(LensModels, return_random_directions_up_to_their_limit_and_show_none_beyond) {
  std::mt19937 random(59);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const Golden& row : golden_points()) {
    SCOPED_TRACE(row.model);
    const Lens lens = lens_of(row.model, row.coefficients);
    if (lens.model->plane == LensPlane::panorama) continue;  // it shows everything
    const bool is_slope = lens.model->plane == LensPlane::perspective;
    const double limit = is_slope ? std::atan(lens.limit) : lens.limit;
    const auto ray = [&](double angle) {
      const double turn = 2 * std::numbers::pi * unit(random);
      return glm::dvec3(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn),
                        std::cos(angle));
    };
    for (int i = 0; i < 300; ++i) {
      const glm::dvec3 seen = ray(0.98 * limit * unit(random));
      const auto pixel = lens.project(seen);
      ASSERT_TRUE(pixel) << i;
      const auto back = lens.direction(*pixel);
      ASSERT_TRUE(back) << i;
      EXPECT_LT(angle_between(*back, seen), 1e-9) << i;
      const double beyond = limit + (std::numbers::pi - limit) * unit(random);
      if (beyond > limit) {
        EXPECT_FALSE(lens.project(ray(beyond))) << i;
      }
    }
  }
}

TEST(LensModels, end_where_the_formula_folds_back) {
  struct Row {
    const char* model;
    std::vector<double> coefficients;
    double limit;  // in the model's plane
  };
  // By hand: the zero of the radial derivative, or of a denominator or a root.
  const double around = std::numbers::pi, ahead = 90 * kDegree - 1e-4;
  const Row rows[] = {
      {"PINHOLE", {}, std::tan(ahead)},
      {"SIMPLE_RADIAL", {-0.2}, std::sqrt(1 / 0.6)},
      {"SIMPLE_RADIAL", {-10}, std::sqrt(1 / 30.0)},
      {"SIMPLE_RADIAL", {0.2}, std::tan(ahead)},
      {"RADIAL", {0, -0.2}, 1},  // 1 - 5 * 0.2 r^4
      {"FULL_OPENCV", {0, 0, 0, 0, 0, -0.25, 0, 0}, 2},
      {"OPENCV_FISHEYE", {kGolden1, kGolden2, kGolden3, kGolden4}, 109.2 * kDegree},
      {"SIMPLE_RADIAL_FISHEYE", {-1.0 / 3}, 1},
      {"FISHEYE", {}, around},
      {"FOV", {0.9}, ahead},
      {"DIVISION", {1}, std::atan(0.5)},  // r <= 1 / (2 sqrt k)
      {"DIVISION", {-1}, ahead},
      {"EUCM", {0.4, 1}, std::acos(-2.0 / 3)},  // alpha + (1 - alpha) cos = 0
      {"EUCM", {1, 1}, 90 * kDegree},           // x / 1: a sine
  };
  for (const Row& row : rows)
    EXPECT_NEAR(lens_of(row.model, row.coefficients).limit / row.limit, 1, 1e-3) << row.model;
  // EUCM, alpha > 1/2: the squared radius of the picture is at most 1 / ((2 alpha - 1) beta).
  const Lens eucm = lens_of("EUCM", {0.6, 1.1});
  const auto edge = eucm.project(from_plane(LensPlane::equidistant, {0.9999999 * eucm.limit, 0}));
  ASSERT_TRUE(edge);
  EXPECT_NEAR((edge->x - 319.5) / 500, std::sqrt(1 / (0.2 * 1.1)), 1e-5);
}

TEST(LensModels, have_no_direction_for_pixels_that_no_direction_reaches) {
  struct Row {
    const char* model;
    std::vector<double> coefficients;
    glm::dvec2 pixel;
  };
  const double infinity = std::numeric_limits<double>::infinity();
  const Row rows[] = {
      {"SIMPLE_RADIAL", {-0.2}, {319.5 + 500 * 0.87, 239.5}},  // its largest radius is 0.861
      {"OPENCV_FISHEYE", {kGolden1, kGolden2, kGolden3, kGolden4}, {319.5 + 500 * 2.5, 239.5}},
      {"FISHEYE", {}, {319.5 + 500 * 3.15, 239.5}},
      {"FOV", {0.9}, {319.5 + 500 * 1.75, 239.5}},  // pi / 2 / omega is 1.745
      {"DIVISION", {-1}, {319.5 + 500 * 1.01, 239.5}},
      {"EUCM", {0.6, 1.1}, {319.5 + 500 * 2.2, 239.5}},  // 2.132
      {"EQUIRECTANGULAR", {}, {1000, 10}},
      {"EQUIRECTANGULAR", {}, {10, -1}},
      {"OPENCV", {kGolden1, kGolden2, kTangential1, kTangential2}, {infinity, 3}},
      {"FISHEYE", {}, {std::nan(""), 3}},
  };
  for (const Row& row : rows)
    EXPECT_FALSE(lens_of(row.model, row.coefficients).direction(row.pixel)) << row.model;
  // 180 degrees and more: an equidistant lens ends behind the eye.
  const Lens fisheye = lens_of("FISHEYE", {});
  for (const double degrees : {89.9, 90.0, 135.0, 179.9, 179.999}) {
    const auto pixel = fisheye.project(from_plane(LensPlane::equidistant, {degrees * kDegree, 0}));
    ASSERT_TRUE(pixel) << degrees;
    EXPECT_NEAR(pixel->x, 319.5 + 500 * degrees * kDegree, 1e-9);
    EXPECT_TRUE(fisheye.direction(*pixel));
  }
  for (const double degrees : {180.1, 200.0, 360.0})
    EXPECT_FALSE(fisheye.direction({319.5 + 500 * degrees * kDegree, 239.5})) << degrees;
}

TEST(LensModels, are_refused_with_hostile_parameters) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  struct Row {
    const char* model;
    std::vector<double> coefficients;
    glm::dvec2 focal;
    const char* sentence;
  };
  const Row rows[] = {
      {"PINHOLE", {}, {0, 500}, "here: the focal length is not above 0"},
      {"PINHOLE", {}, {500, -1}, "here: the focal length is not above 0"},
      {"FISHEYE", {}, {nan, 500}, "here: a parameter is not finite"},
      {"OPENCV", {nan, 0, 0, 0}, {500, 500}, "here: a parameter is not finite"},
      {"EUCM", {0.5, infinity}, {500, 500}, "here: a parameter is not finite"},
      {"FOV", {0}, {500, 500}, "here: omega is 0, but must be between 0 and pi"},
      {"FOV", {3.2}, {500, 500}, "here: omega is 3.2, but must be between 0 and pi"},
      {"EUCM", {-0.1, 1}, {500, 500}, "here: alpha is -0.1, but must be from 0 to 1"},
      {"EUCM", {1.1, 1}, {500, 500}, "here: alpha is 1.1, but must be from 0 to 1"},
      {"EUCM", {0.5, 0}, {500, 500}, "here: beta is 0, but must be above 0"},
      {"SIMPLE_RADIAL", {-1e6}, {500, 500}, "here: the lens distorts too strongly"},
      {"OPENCV_FISHEYE", {-1e300, 1e300, 0, 0}, {500, 500}, "here: the lens distorts too strongly"},
      {"DIVISION", {1e12}, {500, 500}, "here: the lens distorts too strongly"},
  };
  for (const Row& row : rows) {
    Lens lens{find_lens_model(row.model), {640, 480}, row.focal, {319.5, 239.5}};
    std::ranges::copy(row.coefficients, lens.coefficients.begin());
    EXPECT_THAT(test::error_of([&] { lens_camera(lens, "here"); }), HasSubstr(row.sentence))
        << row.model;
  }
  const Lens narrow{find_lens_model("EQUIRECTANGULAR"), {1000, 400}};
  EXPECT_EQ(test::error_of([&] { lens_camera(narrow, "here"); }),
            "here: a panorama of 1000 x 400 pixels is not twice as wide as high");
}

}  // namespace
}  // namespace qs
