// SPDX-License-Identifier: MIT
//
// Pictures for browsers: WebP keeps every colour, JPEG about.

#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>

#include "base/progress.h"
#include "io/picture/image_file.h"
#include "io/picture/webp_image.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

// Noise with every value, and alphas that must not matter.
std::vector<std::uint8_t> noise(int width, int height) {
  std::vector<std::uint8_t> rgba(4 * static_cast<std::size_t>(width * height));
  std::uint32_t state = 1;
  for (std::uint8_t& value : rgba) {
    state = state * 1664525 + 1013904223;
    value = static_cast<std::uint8_t>(state >> 24);
  }
  return rgba;
}

TEST(Encode, lossless_pictures_keep_every_colour) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 7}, {64, 48}, {257, 3}}) {
    const std::vector<std::uint8_t> rgba = noise(width, height);
    const std::string file = encode_webp({rgba, width, height});
    const auto decoded = decode_webp(std::as_bytes(std::span(file)), "test");
    ASSERT_EQ(decoded.size(), rgba.size());
    for (std::size_t i = 0; i < rgba.size(); ++i)
      ASSERT_EQ(decoded[i], i % 4 == 3 ? 255 : rgba[i]) << width << " " << i;
  }
}

TEST(Encode, a_stop_ends_a_lossless_picture) {
  std::stop_source stop;
  stop.request_stop();
  const std::vector<std::uint8_t> rgba = noise(64, 64);
  EXPECT_THROW(encode_webp({rgba, 64, 64}, stop.get_token()), Cancelled);
}

TEST(Encode, jpegs_are_close) {
  constexpr int kWidth = 33, kHeight = 17;
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const int x = i % kWidth, y = i / kWidth;
    for (const int value : {7 * x, 255 - 7 * x, 14 * y, 0})
      rgba.push_back(static_cast<std::uint8_t>(value));
  }
  const TemporaryFolder folder;
  std::ofstream(folder / "a.jpg", std::ios::binary) << encode_jpeg({rgba, kWidth, kHeight}, 90);
  const Image image = read_image(folder / "a.jpg");
  ASSERT_EQ(image.width, kWidth);
  ASSERT_EQ(image.height, kHeight);
  for (int i = 0; i < kWidth * kHeight; ++i) {
    for (int c = 0; c < 3; ++c) {
      const int given = rgba[static_cast<std::size_t>(4 * i + c)];
      EXPECT_LE(std::abs(to_8bit(image.at(i % kWidth, i / kWidth, c)) - given), 12);
    }
  }
}

}  // namespace
}  // namespace qs
