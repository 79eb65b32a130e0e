// SPDX-License-Identifier: MIT
//
// Pictures for video codecs: colours against BT.601 in double precision, and VP9 there and back.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "io/picture/vp9.h"

namespace qs {
namespace {

using Rgba = std::vector<std::uint8_t>;

Rgba noise_of(int width, int height, std::uint32_t state = 1) {
  Rgba rgba(4 * static_cast<std::size_t>(width * height));
  for (std::uint8_t& value : rgba) {
    state = state * 1664525 + 1013904223;
    value = static_cast<std::uint8_t>(state >> 24);
  }
  return rgba;
}

struct Yuv {
  double y, u, v;
};

// ITU-R BT.601, limited range, from 8-bit colours.
Yuv yuv_of(double r, double g, double b) {
  const double y = 0.299 * r + 0.587 * g + 0.114 * b;
  return {16 + 219 * y / 255, 128 + 112 * (b - y) / (255 * (1 - 0.114)),
          128 + 112 * (r - y) / (255 * (1 - 0.299))};
}

Yuv reference(const Rgba& rgba, int width, int height, int x, int y, int step) {
  double sum[3] = {0, 0, 0};
  for (int i = 0; i < step * step; ++i) {
    const int column = std::min(x + i % step, width - 1), row = std::min(y + i / step, height - 1);
    for (int c = 0; c < 3; ++c)
      sum[c] += rgba[static_cast<std::size_t>(4 * (row * width + column) + c)];
  }
  const double count = step * step;
  return yuv_of(sum[0] / count, sum[1] / count, sum[2] / count);
}

class I420Sizes : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(I420Sizes, colours_are_those_of_bt601) {
  const auto [width, height] = GetParam();
  const Rgba rgba = noise_of(width, height);
  I420 planes;
  planes.set({rgba, width, height});
  ASSERT_EQ(planes.width(), width);
  ASSERT_EQ(planes.height(), height);
  double luma = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int found =
          planes.y()[static_cast<std::size_t>(y) * planes.stride() + static_cast<std::size_t>(x)];
      const double expected = reference(rgba, width, height, x, y, 1).y;
      ASSERT_LE(std::abs(found - expected), 1) << x << " " << y;
      luma += found - expected;
    }
  }
  EXPECT_LE(std::abs(luma), 0.3 * width * height + 1) << "no colour cast";
  for (int y = 0; y < planes.chroma_height(); ++y) {
    for (int x = 0; x < planes.chroma_width(); ++x) {
      const std::size_t at =
          static_cast<std::size_t>(y) * planes.chroma_stride() + static_cast<std::size_t>(x);
      const Yuv expected = reference(rgba, width, height, 2 * x, 2 * y, 2);
      ASSERT_LE(std::abs(planes.u()[at] - expected.u), 1.3) << x << " " << y;
      ASSERT_LE(std::abs(planes.v()[at] - expected.v), 1.3) << x << " " << y;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, I420Sizes,
                         testing::Values(std::pair(1, 1), std::pair(2, 2), std::pair(3, 5),
                                         std::pair(31, 2), std::pair(64, 48), std::pair(65, 3),
                                         std::pair(127, 9), std::pair(257, 33)));

TEST(I420, greys_have_no_chroma_and_black_and_white_the_ends_of_the_range) {
  for (int grey = 0; grey < 256; ++grey) {
    const Rgba rgba(4 * 4 * 4, static_cast<std::uint8_t>(grey));
    I420 planes;
    planes.set({rgba, 4, 4});
    EXPECT_EQ(planes.u()[0], 128) << grey;
    EXPECT_EQ(planes.v()[0], 128) << grey;
    EXPECT_NEAR(planes.y()[0], 16 + 219.0 * grey / 255, 1);
    EXPECT_TRUE(grey != 0 || planes.y()[0] == 16);
    EXPECT_TRUE(grey != 255 || planes.y()[0] == 235);
  }
}

TEST(I420, a_picture_of_another_size_replaces_the_old_one) {
  I420 planes, fresh;
  const Rgba large = noise_of(200, 100, 2), small = noise_of(33, 7, 3);
  planes.set({large, 200, 100});
  planes.set({small, 33, 7});
  fresh.set({small, 33, 7});
  EXPECT_EQ(planes.chroma_width(), 17);
  EXPECT_EQ(planes.chroma_height(), 4);
  for (std::size_t y = 0; y < 7; ++y) {
    EXPECT_TRUE(std::equal(planes.y() + y * planes.stride(), planes.y() + y * planes.stride() + 33,
                           fresh.y() + y * fresh.stride()));
  }
}

}  // namespace
}  // namespace qs
