// SPDX-License-Identifier: MIT
//
// The ground, scales and rows of measured points.
#include "raster/select/measures.h"

#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace qs {
namespace {

SurfacePoint point_at(glm::dvec3 position, double along = 0.01) {
  SurfacePoint point;
  point.position = position;
  point.direction = {0, 0, 1};
  point.distance = position.z;
  point.along = along;
  point.across = 0.002;
  return point;
}

TEST(Ground, has_the_eye_above_it_and_snaps_to_axes) {
  struct Case {
    glm::dvec3 b, c, up;
  };
  const double tilt = std::tan(glm::radians(2.9)), steep = std::tan(glm::radians(3.1));
  const Case cases[] = {{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
                        {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}},
                        {{1, 0, tilt}, {0, 1, 0}, {0, 0, -1}},
                        {{1, 0, 0}, {0, 1, -tilt}, {0, 0, -1}},
                        {{1, 0, steep}, {0, 1, 0}, glm::normalize(glm::dvec3(steep, 0, -1))},
                        {{1, 0, 1}, {0, 1, 0}, glm::normalize(glm::dvec3(1, 0, -1))},
                        {{1, 0, 0}, {0, 0.01, 1}, glm::dvec3(0, 1, 0)},
                        {{1e-3, 0, 0}, {0, 1e-3, 0}, {0, 0, -1}}};
  for (const Case& each : cases) {
    const glm::dvec3 at(3, 4, 5);
    const auto ground =
        ground_through(std::array{point_at(at), point_at(at + each.b), point_at(at + each.c)});
    ASSERT_TRUE(ground);
    EXPECT_EQ(ground->point, at);
    EXPECT_LT(glm::length(glm::abs(ground->up) - glm::abs(each.up)), 1e-12);
    EXPECT_LE(glm::dot(ground->up, glm::dvec3(0, 0, 1)), 0.01);
    EXPECT_LT(glm::length(level_turn(ground->up) * ground->up - glm::dvec3(0, -1, 0)), 1e-9);
  }
  EXPECT_FALSE(
      ground_through(std::array{point_at({0, 0, 1}), point_at({1, 0, 1}), point_at({3, 0, 1})}));
  EXPECT_FALSE(
      ground_through(std::array{point_at({0, 0, 1}), point_at({0, 0, 1}), point_at({0, 0, 1})}));
}

// Against planes through points that are moved at random by their errors.
TEST(Ground, has_the_error_of_its_tilt) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const double c : {1.0, 0.3, 0.1}) {
    std::array points{point_at({0, 0, 5}, 0.003), point_at({1, 0, 5.2}, 0.003),
                      point_at({0.4, c, 5.1}, 0.003)};
    for (SurfacePoint& point : points) point.direction = glm::normalize(point.position);
    const auto up = [](const std::array<SurfacePoint, 3>& three) {
      return glm::normalize(
          glm::cross(three[1].position - three[0].position, three[2].position - three[0].position));
    };
    double squares = 0;
    constexpr int kTrials = 4000;
    for (int i = 0; i < kTrials; ++i) {
      std::array moved = points;
      for (SurfacePoint& point : moved) {
        const glm::dvec3 aside =
            glm::normalize(glm::cross(point.direction, glm::dvec3(normal(random), 1, 0)));
        point.position += point.along * normal(random) * point.direction +
                          point.across * normal(random) * aside +
                          point.across * normal(random) * glm::cross(point.direction, aside);
      }
      const double angle = glm::degrees(std::asin(glm::length(glm::cross(up(points), up(moved)))));
      squares += angle * angle;
    }
    const double expected = std::sqrt(squares / kTrials);
    EXPECT_NEAR(degrees_of_tilt_error(points), expected, 0.05 * expected) << c;
  }
}

TEST(MeasureScale, makes_a_known_length_of_two_points) {
  const SurfacePoint a = point_at({0, 0, 4}), b = point_at({0, 0, 6});
  const auto scale = scale_of(a, b, 0.5, "m");
  ASSERT_TRUE(scale);
  EXPECT_DOUBLE_EQ(scale->factor, 0.25);
  EXPECT_NEAR(scale->error, std::hypot(0.01, 0.01) / 2, 1e-12);
  EXPECT_EQ(scale->name(), "m");
  EXPECT_EQ(MeasureScale().name(), "units");
  EXPECT_FALSE(scale_of(a, a, 0.5, "m"));
  // Other lengths have the scale's error too.
  const MeasuredLeg leg = measured_leg(a, point_at({0, 4, 4}, 0), *scale);
  EXPECT_DOUBLE_EQ(leg.length.length, 1);
  EXPECT_EQ(leg.offset, glm::dvec3(0, 1, 0));
  EXPECT_NEAR(leg.length.error, 0.25 * std::hypot(std::hypot(0.002, 0.002), scale->error * 4),
              1e-12);
}

TEST(MeasureRows, have_distances_their_sum_and_angles) {
  const std::vector<SurfacePoint> line = {point_at({0, 0, 4}, 0), point_at({3, 0, 4}, 0),
                                          point_at({3, 4, 4}, 0)};
  const auto rows = measure_rows(line, 7, {2, 0, "cm"}, glm::dvec3(0, -1, 0));
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0].name, "7 to 8");
  EXPECT_EQ(rows[0].value, "6 ± 0.0057 cm");
  EXPECT_EQ(rows[0].more, "x 6, y 0, z 0; height 0");
  EXPECT_EQ(rows[1].more, "x 0, y 8, z 0; height -8");
  // A turn leaves nothing but rounding of a height.
  const auto turned = measure_rows(line, 1, {}, glm::dvec3(1e-18, -1, 0));
  EXPECT_EQ(turned[0].more, "x 3, y 0, z 0; height 0");
  EXPECT_EQ(length_text(-2.45e-18, 0.003, "m"), "0 ± 0.003 m");
  EXPECT_EQ(rows[2].name, "together");
  EXPECT_EQ(rows[2].value, "14 ± 0.008 cm");
  EXPECT_EQ(rows[3].name, "angle at 8");
  EXPECT_EQ(rows[3].value, "90.00 degrees");
  EXPECT_TRUE(measure_rows({}, 1, {}, {}).empty());
  EXPECT_TRUE(measure_rows(std::span(line).first(1), 1, {}, {}).empty());
  EXPECT_EQ(measure_rows(std::span(line).first(2), 1, {}, {})[0].more, "x 3, y 0, z 0");
}

}  // namespace
}  // namespace qs
