// SPDX-License-Identifier: MIT
//
// Shapes in a picture: the even-odd rule, half-open edges, strokes.
#include "raster/select/shape.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace qs::test {
namespace {

using Points = std::vector<glm::dvec2>;

TEST(Shapes, a_rectangle_has_its_upper_and_left_border_only) {
  for (const Shape& shape :
       {Shape::rectangle({2, 3}, {5, 7}), Shape::rectangle({5, 3}, {2, 7}),
        Shape::rectangle({5, 7}, {2, 3}), Shape::polygon(Points{{2, 3}, {2, 7}, {5, 7}, {5, 3}})}) {
    EXPECT_TRUE(shape.contains({2, 3}));
    EXPECT_TRUE(shape.contains({4.999, 6.999}));
    EXPECT_FALSE(shape.contains({5, 5}));
    EXPECT_FALSE(shape.contains({3, 7}));
    EXPECT_FALSE(shape.contains({1.999, 5}));
    EXPECT_FALSE(shape.contains({NAN, 5}));
    const PixelBox box = shape.pixels({100, 6});
    EXPECT_EQ(box.x0, 2);
    EXPECT_EQ(box.x1, 6);
    EXPECT_EQ(box.y0, 3);
    EXPECT_EQ(box.y1, 6);
  }
}

TEST(Shapes, polygons_that_share_their_edges_share_no_point_and_leave_none_out) {
  // A fan of triangles around a point in a square, with points on every edge and corner.
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(0, 64);
  const glm::dvec2 hub(20, 30);
  const Points rim = {{0, 0}, {40, 0}, {64, 0}, {64, 64}, {13, 64}, {0, 64}, {0, 17}};
  std::vector<Shape> fan;
  for (std::size_t i = 0; i < rim.size(); ++i)
    fan.push_back(Shape::polygon(Points{hub, rim[i], rim[(i + 1) % rim.size()]}));
  const Shape whole = Shape::rectangle({0, 0}, {64, 64});
  const auto expect_one = [&](glm::dvec2 point) {
    int owners = 0;
    for (const Shape& part : fan) owners += part.contains(point);
    EXPECT_EQ(owners, whole.contains(point)) << point.x << " " << point.y;
  };
  for (int i = 0; i < 2000; ++i) expect_one({place(random), place(random)});
  for (int y = -1; y <= 65; ++y)
    for (int x = -1; x <= 65; ++x) expect_one({x, y});
}

TEST(Shapes, a_polygon_that_crosses_itself_is_empty_where_it_winds_twice) {
  const Shape star =
      Shape::polygon(Points{{0, -10}, {5.9, 8.1}, {-9.5, -3.1}, {9.5, -3.1}, {-5.9, 8.1}});
  EXPECT_FALSE(star.contains({0, 0}));
  EXPECT_TRUE(star.contains({0, -7}));
  EXPECT_TRUE(star.contains({7, -2.5}));
}

TEST(Shapes, a_stroke_has_the_points_within_its_radius) {
  const Shape stroke = Shape::stroke(Points{{10, 10}, {30, 10}, {30, 30}}, 5);
  const std::pair<glm::dvec2, bool> kPoints[] = {
      {{5, 10}, true},      {{4.99, 10}, false}, {{20, 15}, true},
      {{20, 15.01}, false}, {{30, 35}, true},    {{33, 34}, true},
      {{33.01, 34}, false}, {{25.01, 25}, true}, {{24.9, 25}, false}};
  for (const auto& [point, inside] : kPoints)
    EXPECT_EQ(stroke.contains(point), inside) << point.x << " " << point.y;
  const Shape dot = Shape::stroke(Points{{3, 4}}, 2);
  EXPECT_TRUE(dot.contains({3, 6}));
  EXPECT_FALSE(dot.contains({4.5, 5.5}));
}

TEST(Shapes, without_an_inside_contain_nothing) {
  for (const Shape& shape :
       {Shape::polygon({}), Shape::polygon(Points{{1, 1}}), Shape::polygon(Points{{1, 1}, {9, 9}}),
        Shape::rectangle({4, 4}, {4, 9}), Shape::stroke({}, 5),
        Shape::polygon(Points(4096, glm::dvec2(2, 2)))}) {
    EXPECT_FALSE(shape.contains({4, 5}));
    EXPECT_FALSE(shape.contains({1, 1}));
  }
  const PixelBox none = Shape::polygon({}).pixels({10, 10});
  EXPECT_EQ(none.x1 - none.x0, 0);
  const PixelBox outside = Shape::rectangle({-50, -50}, {-20, -20}).pixels({10, 10});
  EXPECT_EQ(outside.x1 - outside.x0, 0);
}

TEST(Shapes, of_many_corners_decide_as_the_plain_rule) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-20, 120);
  Points corners;
  for (int i = 0; i < 700; ++i) corners.emplace_back(place(random), place(random));
  const Shape shape = Shape::polygon(corners);
  for (int i = 0; i < 3000; ++i) {
    const glm::dvec2 point(place(random), place(random));
    bool inside = false;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const glm::dvec2 a = corners[k], b = corners[(k + 1) % corners.size()];
      if ((a.y > point.y) == (b.y > point.y)) continue;
      inside ^= point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y) + a.x;
    }
    EXPECT_EQ(shape.contains(point), inside);
  }
}

TEST(Shapes, choose_the_pixels_of_a_row_that_they_contain) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-20, 120);
  Points corners;
  for (int i = 0; i < 90; ++i) corners.emplace_back(place(random), place(random));
  corners.insert(corners.end(), {{10, 7}, {40, 7}, {40, 63}, {10, 63}});  // at centres of pixels
  for (const Shape& shape :
       {Shape::polygon(corners), Shape::polygon(std::span(corners).last<4>()),
        Shape::rectangle({-9, 3.5}, {200, 70}), Shape::stroke(std::span(corners).first<9>(), 6)}) {
    const PixelBox box = shape.pixels({100, 80});
    std::vector<std::uint8_t> row(static_cast<std::size_t>(box.x1 - box.x0));
    for (int y = box.y0; y < box.y1; ++y) {
      shape.choose_row({box.x0, y}, row);
      for (int x = box.x0; x < box.x1; ++x)
        EXPECT_EQ(row[static_cast<std::size_t>(x - box.x0)], shape.contains({x, y}))
            << x << " " << y;
    }
  }
}

}  // namespace
}  // namespace qs::test
