// SPDX-License-Identifier: MIT
#include "app/picture/image_difference.h"

#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "io/picture/image_file.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

TEST(ImageDifference, names_the_first_pixel_with_the_largest_difference_and_compares_only_the_box) {
  constexpr int kWidth = 4, kHeight = 3;
  std::vector<std::uint8_t> a(4 * kWidth * kHeight, 100), b = a;
  const auto value = [&](int x, int y, int c) -> std::uint8_t& {
    return b[static_cast<std::size_t>(4 * (y * kWidth + x) + c)];
  };
  const PixelBox all{0, 0, kWidth, kHeight};
  EXPECT_EQ(image_difference(a, b, kWidth, all).pixels, 0u);
  EXPECT_TRUE(std::isinf(image_difference(a, b, kWidth, all).psnr));
  EXPECT_EQ(image_difference(a, b, kWidth, all).largest_at, glm::ivec2(-1));

  value(3, 0, 1) = 97;
  value(1, 2, 0) = 105;
  value(2, 2, 2) = 95;
  value(0, 1, 3) = 0;  // opacity is no colour
  const ImageDifference whole = image_difference(a, b, kWidth, all);
  EXPECT_EQ(whole.largest, 5);
  EXPECT_EQ(whole.largest_at, glm::ivec2(1, 2));
  EXPECT_EQ(whole.pixels, 3u);
  EXPECT_NEAR(whole.psnr, 10 * std::log10(255.0 * 255.0 / ((9.0 + 25 + 25) / (3 * 12))), 1e-12);

  const ImageDifference row = image_difference(a, b, kWidth, {0, 0, kWidth, 1});
  EXPECT_EQ(row.largest, 3);
  EXPECT_EQ(row.pixels, 1u);
  EXPECT_NEAR(row.psnr, 10 * std::log10(255.0 * 255.0 / (9.0 / (3 * 4))), 1e-12);
}

TEST(ImageDifference, pixels_count_when_they_exceed_the_tolerance) {
  Image a(5, 4, 3), b = a;
  b.at(4, 0, 1) = 3.0f / 255;
  a.at(2, 1, 2) = 2.0f / 255;
  a.at(0, 3, 0) = 9.0f / 255;
  EXPECT_EQ(image_difference(a, b).pixels, 3u);
  EXPECT_EQ(image_difference(a, b).first, glm::ivec2(4, 0));
  const ImageDifference above = image_difference(a, b, {}, 3);
  EXPECT_EQ(above.pixels, 1u);
  EXPECT_EQ(above.first, glm::ivec2(0, 3));
  EXPECT_EQ(above.psnr, psnr_8bit(a, b)) << "the tolerance does not affect it";
  const ImageDifference part = image_difference(a, b, PixelBox{1, 1, 5, 4}, 1);
  EXPECT_EQ(part.first, glm::ivec2(2, 1));
  EXPECT_EQ(part.largest, 2);
  EXPECT_FALSE(image_difference(a, a).first.has_value());
  EXPECT_EQ(amplification_for(0), 64);
  EXPECT_EQ(amplification_for(9), 28);
  EXPECT_EQ(amplification_for(255), 1);
}

TEST(ImageDifference, is_amplified_up_to_white) {
  Image truth(4, 1, 3), other = truth;
  other.at(1, 0, 0) = 2.0f / 255;
  other.at(2, 0, 0) = 1;
  const Image difference = amplified_difference(other, truth, {1, 0, 4, 1}, 16);
  EXPECT_FLOAT_EQ(difference.at(0, 0, 0), 32.0f / 255);
  EXPECT_FLOAT_EQ(difference.at(1, 0, 0), 1);
  EXPECT_EQ(difference.at(2, 0, 0), 0);
}

TEST(ImageDifference, reads_a_reference_of_the_frame_s_size_as_rgb) {
  const TemporaryFolder folder;
  Image gray(5, 3, 1), rgb(5, 3, 3);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 5; ++x) {
      const float value = static_cast<float>(17 * x + 51 * y) / 255;
      gray.at(x, y, 0) = value;
      for (int c = 0; c < 3; ++c) rgb.at(x, y, c) = value;
    }
  }
  write_image(gray, folder / "gray.png");
  write_image(rgb, folder / "rgb.png");
  for (const char* name : {"gray.png", "rgb.png"}) {
    const Image image = read_reference(folder / name, 5, 3);
    ASSERT_EQ(image.channels, 3) << name;
    EXPECT_EQ(image.values, rgb.values) << name;
  }
  for (const glm::ivec2 size : {glm::ivec2(4, 3), {5, 4}}) {
    try {
      read_reference(folder / "rgb.png", size.x, size.y);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.what(), fmt::format("{}: is 5 x 3 pixels, but the frame is {} x {}",
                                          (folder / "rgb.png").string(), size.x, size.y));
    }
  }
}

TEST(ImageDifference, is_made_visible_by_a_power_of_two_that_clips_at_most_two_per_cent) {
  const Image black(40, 25, 3);  // 1000 pixels
  const auto difference = [&](std::vector<int> sizes) {
    Image other = black;
    for (std::size_t i = 0; i < sizes.size(); ++i)
      other.values[3 * i + i % 3] = static_cast<float>(sizes[i]) / 255;
    return image_difference(black, other);
  };
  EXPECT_EQ(difference({}).usual, 0);
  EXPECT_EQ(visible_amplification(difference({})), 128);
  std::vector<int> sizes(100, 3);
  EXPECT_EQ(difference(sizes).usual, 3);
  sizes[7] = 200;
  sizes[50] = 90;
  EXPECT_EQ(difference(sizes).usual, 3) << "2 of 100 differ by more";
  EXPECT_EQ(visible_amplification(difference(sizes)), 64);
  sizes[51] = 80;
  EXPECT_EQ(difference(sizes).usual, 80) << "3 would";
  EXPECT_EQ(visible_amplification(difference(sizes)), 2);
  for (int size = 1; size <= 255; ++size) {
    const int factor = visible_amplification(difference(std::vector<int>(5, size)));
    EXPECT_LE(factor * size, 255);
    EXPECT_TRUE(factor == 128 || 2 * factor * size > 255) << size;
    EXPECT_EQ(factor & (factor - 1), 0) << "a power of two";
  }
}

TEST(ImageDifference, is_amplified_as_far_as_the_largest_one_allows) {
  for (int largest = 0; largest <= 255; ++largest) {
    const int factor = amplification_for(largest);
    EXPECT_TRUE(factor == 64 || (factor + 1) * largest > 255) << largest;
    EXPECT_TRUE(factor == 1 || factor * largest <= 255) << largest;
    EXPECT_TRUE(factor >= 1 && factor <= 64);
  }
  EXPECT_EQ(difference_path("out/a.b.ppm"), "out/a.b.difference.png");
}

}  // namespace
}  // namespace qs
