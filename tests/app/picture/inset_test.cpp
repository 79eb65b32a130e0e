// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "app/picture/canvas.h"

namespace qs {
namespace {

// Red grows to the right, green downwards.
Image ramp(int width, int height) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at(x, y, 0) = 0.01f * static_cast<float>(x);
      image.at(x, y, 1) = 0.01f * static_cast<float>(y);
    }
  }
  return image;
}

TEST(Inset, an_enlarged_part_shows_the_same_colours_on_more_pixels) {
  const Image part = enlarged(ramp(80, 60), {20, 10, 8, 4}, 2.5);
  ASSERT_EQ(part.width, 20);
  ASSERT_EQ(part.height, 10);
  for (int x = 2; x < 18; ++x) {
    EXPECT_NEAR(part.at(x, 5, 0), 0.01 * (20 + (x + 0.5) / 2.5 - 0.5), 1e-5) << x;
  }
  for (int y = 2; y < 8; ++y)
    EXPECT_NEAR(part.at(5, y, 1), 0.01 * (10 + (y + 0.5) / 2.5 - 0.5), 1e-5) << y;
  EXPECT_NEAR(part.at(0, 0, 0), 0.2f, 1e-6f) << "nothing outside of the part is read";
  EXPECT_NEAR(part.at(19, 0, 0), 0.27f, 1e-6f);
  EXPECT_EQ(enlarged(ramp(3, 3), {2, 1, 1, 1}, 1).at(0, 0, 0), 0.02f);
}

TEST(Inset, lies_in_the_corner_farthest_from_its_part) {
  const Image image = ramp(80, 60);
  for (const auto& [part, corner] : {std::pair{PixelRect{4, 4, 10, 8}, glm::ivec2(60, 44)},
                                     {{60, 4, 10, 8}, {0, 44}},
                                     {{4, 50, 10, 8}, {60, 0}},
                                     {{60, 50, 10, 8}, {0, 0}}}) {
    const Image shown = with_inset(image, part, 2);
    const Image inset = enlarged(image, part, 2);
    for (int y = 0; y < inset.height; ++y) {
      for (int x = 0; x < inset.width; ++x)
        ASSERT_EQ(shown.at(corner.x + x, corner.y + y, 0), inset.at(x, y, 0));
    }
    EXPECT_EQ(shown.at(part.x, part.y, 0), image.at(part.x, part.y, 0)) << "the part is not hidden";
    EXPECT_NEAR(shown.at(part.x - 1, part.y, 0), 0.9f, 1e-6f) << "it has a frame";
  }
}

}  // namespace
}  // namespace qs
