// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "app/picture/canvas.h"

namespace qs {
namespace {

TEST(Stroke, covers_as_much_as_its_length_and_width) {
  Image image(60, 40, 3);
  const glm::vec2 points[] = {{10.3f, 20.7f}, {50.3f, 20.7f}};
  stroke(image, points, false, {glm::vec3(1), 4});
  float sum = 0;
  for (std::size_t i = 0; i < image.values.size(); i += 3) sum += image.values[i];
  EXPECT_NEAR(sum, 40 * 4 + 3.14f * 4, 3);  // two half discs at the ends
}

TEST(Stroke, is_blended_once_where_it_crosses_itself) {
  Image image(40, 40, 3);
  const glm::vec2 points[] = {{5, 5}, {35, 35}, {35, 5}, {5, 35}};
  stroke(image, points, false, {glm::vec3(1), 5, 0.5f});
  for (const float value : image.values) EXPECT_LE(value, 0.5f);
  EXPECT_FLOAT_EQ(image.at(20, 20, 0), 0.5f);
}

TEST(Stroke, dashes_leave_gaps_of_their_own_length) {
  Image image(100, 10, 3);
  const glm::vec2 points[] = {{0, 5}, {100, 5}};
  stroke(image, points, false, {glm::vec3(1), 2, 1, 10});
  EXPECT_GT(image.at(5, 5, 0), 0.9f);
  EXPECT_EQ(image.at(15, 5, 0), 0);
  EXPECT_GT(image.at(25, 5, 0), 0.9f);
}

TEST(Stroke, polygons_have_their_area_and_everything_is_clipped) {
  Image image(50, 50, 3);
  const glm::vec2 triangle[] = {{10, 10}, {40, 10}, {10, 40}};
  fill_polygon(image, triangle, glm::vec3(1), 1);
  float sum = 0;
  for (std::size_t i = 0; i < image.values.size(); i += 3) sum += image.values[i];
  EXPECT_NEAR(sum, 450, 2);
  const glm::vec2 outside[] = {{-500, -500}, {900, -20}, {700, 900}};
  fill_polygon(image, outside, glm::vec3(0.5f), 1);
  stroke(image, outside, true, {glm::vec3(1), 3});
  EXPECT_FLOAT_EQ(image.at(49, 25, 1), 0.5f);
}

}  // namespace
}  // namespace qs
