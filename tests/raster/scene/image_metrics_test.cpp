// SPDX-License-Identifier: MIT
// PSNR, SSIM and area averaging against straightforward implementations of their definitions.
#include "raster/scene/image_metrics.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace qs {
namespace {

Image noise(int width, int height, int channels, unsigned seed) {
  Image image(width, height, channels);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (float& value : image.values) value = uniform(random);
  return image;
}

// SSIM with a square window of 121 weights at every pixel that the mask does not exclude;
// excluded pixels are 0. The `margin` outermost pixels do not count.
double ssim_by_definition(const Image& a, const Image& b, int margin = 0,
                          const std::vector<std::uint8_t>& mask = {}) {
  double total = 0;
  std::size_t counted = 0;
  const auto is_out = [&](int x, int y) {
    return x < 0 || x >= a.width || y < 0 || y >= a.height ||
           (!mask.empty() && mask[static_cast<std::size_t>(y * a.width + x)] == 0);
  };
  for (int c = 0; c < a.channels; ++c) {
    for (int y = margin; y < a.height - margin; ++y) {
      for (int x = margin; x < a.width - margin; ++x) {
        if (is_out(x, y)) continue;
        ++counted;
        double weights = 0, ma = 0, mb = 0, maa = 0, mbb = 0, mab = 0;
        for (int dy = -5; dy <= 5; ++dy) {
          for (int dx = -5; dx <= 5; ++dx) {
            const double w = std::exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5));
            weights += w;
            if (is_out(x + dx, y + dy)) continue;
            const auto va = static_cast<double>(a.at(x + dx, y + dy, c));
            const auto vb = static_cast<double>(b.at(x + dx, y + dy, c));
            ma += w * va;
            mb += w * vb;
            maa += w * va * va;
            mbb += w * vb * vb;
            mab += w * va * vb;
          }
        }
        for (double* m : {&ma, &mb, &maa, &mbb, &mab}) *m /= weights;
        const double numerator = (2 * ma * mb + 1e-4) * (2 * (mab - ma * mb) + 9e-4);
        total += numerator / ((ma * ma + mb * mb + 1e-4) * (maa - ma * ma + mbb - mb * mb + 9e-4));
      }
    }
  }
  return total / static_cast<double>(counted);
}

std::vector<std::uint8_t> random_mask(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(width * height), 1);
  for (std::uint8_t& value : mask) value = random() % 3 == 0 ? 0 : 1;
  return mask;
}

// Averages samples so fine that they represent every fraction of a pixel exactly.
double mean_of_area(const Image& image, int x, int y, int c, int width, int height) {
  double sum = 0;
  for (int i = 0; i < image.width; ++i) {  // 1 / image.width of the new pixel
    for (int k = 0; k < image.height; ++k) {
      const int column = (x * image.width + i) / width, row = (y * image.height + k) / height;
      sum += static_cast<double>(image.at(column, row, c));
    }
  }
  return sum / (static_cast<double>(image.width) * image.height);
}

TEST(WorstBlock, is_the_block_with_the_largest_error) {
  Image a(150, 70, 3), b = a;  // blocks of 64 and 64 and 22 columns, 64 and 6 rows
  EXPECT_EQ(worst_block_psnr(a, b), std::numeric_limits<double>::infinity());
  b.at(10, 10, 0) = 0.9f;   // 0.81 / (64 * 64 * 3)
  b.at(149, 69, 2) = 0.5f;  // 0.25 / (22 * 6 * 3)
  EXPECT_NEAR(worst_block_psnr(a, b), -10 * std::log10(0.25 / (22 * 6 * 3)), 1e-5);
  b.at(149, 69, 2) = 0;
  EXPECT_NEAR(worst_block_psnr(a, b), -10 * std::log10(0.81 / (64 * 64 * 3)), 1e-5);
  EXPECT_NEAR(worst_block_psnr(a, b, 1), -10 * std::log10(0.81 / 3), 1e-5);
  EXPECT_NEAR(worst_block_psnr(a, b, 1000), -10 * std::log10(0.81 / (150 * 70 * 3)), 1e-5);
}

TEST(BlockErrors, are_means_of_squares_row_by_row) {
  Image a(150, 70, 3), b = a;  // blocks of 64 and 64 and 22 columns, 64 and 6 rows
  b.at(10, 10, 0) = 0.5f;
  b.at(63, 63, 2) = -1;
  b.at(149, 69, 2) = 2;
  EXPECT_EQ(block_errors(a, b),
            (std::vector<double>{1.25 / (64 * 64 * 3), 0, 0, 0, 0, 4. / (22 * 6 * 3)}));
}

TEST(ImageMetrics, psnr_is_the_logarithm_of_the_mean_squared_error) {
  ThreadPool pool(2);
  const Image a = noise(53, 71, 3, 1);
  Image b = a;
  EXPECT_EQ(psnr(a, b, pool), INFINITY);
  for (float& value : b.values) value += 0.1f;
  EXPECT_NEAR(psnr(a, b, pool), 20, 1e-4);
  b = a;
  b.values[17] += 0.5f;
  EXPECT_NEAR(psnr(a, b, pool), -10 * std::log10(0.25 / (53 * 71 * 3)), 1e-4);
}

TEST(ImageMetrics, ssim_is_its_definition) {
  ThreadPool pool(3);
  for (const auto& [width, height, channels] :
       {std::tuple{1, 1, 1}, {3, 40, 3}, {40, 3, 1}, {37, 41, 3}}) {
    const Image a = noise(width, height, channels, 2);
    Image b = noise(width, height, channels, 3);
    for (std::size_t i = 0; i < b.values.size(); ++i)
      b.values[i] = 0.7f * a.values[i] + 0.3f * b.values[i];
    EXPECT_NEAR(ssim(a, b, pool), ssim_by_definition(a, b), 1e-9) << width << "x" << height;
    EXPECT_NEAR(ssim(a, a, pool), 1, 1e-12);
    if (width < 11 || height < 11) continue;
    EXPECT_NEAR(ssim(a, b, pool, SsimBorder::crop), ssim_by_definition(a, b, 5), 1e-9);
  }
}

TEST(ImageMetrics, masked_pixels_do_not_count_and_are_outside_for_ssim) {
  ThreadPool pool(3);
  const Image a = noise(37, 41, 3, 2), b = noise(37, 41, 3, 3);
  const std::vector<std::uint8_t> mask = random_mask(37, 41, 7);
  EXPECT_NEAR(ssim(a, b, pool, SsimBorder::zeros, mask), ssim_by_definition(a, b, 0, mask), 1e-9);
  EXPECT_NEAR(ssim(a, b, pool, SsimBorder::crop, mask), ssim_by_definition(a, b, 5, mask), 1e-9);
  const std::vector<std::uint8_t> all(37 * 41, 1);
  EXPECT_EQ(ssim(a, b, pool, SsimBorder::zeros, all), ssim(a, b, pool));
  double error = 0, counted = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    if (mask[i / 3] == 0) continue;
    const double difference = static_cast<double>(a.values[i]) - static_cast<double>(b.values[i]);
    error += difference * difference;
    ++counted;
  }
  EXPECT_NEAR(psnr(a, b, pool, mask), -10 * std::log10(error / counted), 1e-9);
  Image hidden = b;  // equal to a in the pixels that count
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    if (mask[i / 3] != 0) hidden.values[i] = a.values[i];
  }
  EXPECT_EQ(psnr(a, hidden, pool, mask), INFINITY);
  EXPECT_NEAR(ssim(a, hidden, pool, SsimBorder::zeros, mask), 1, 1e-12);
}

TEST(ImageMetrics, averaging_counts_parts_of_pixels_by_their_area) {
  ThreadPool pool(2);
  const Image image = noise(12, 9, 3, 4);
  for (const auto& [width, height] :
       {std::pair{6, 3}, {12, 9}, {5, 4}, {1, 1}, {11, 2}, {24, 18}, {17, 10}}) {
    const Image result = area_average(image, width, height, pool);
    ASSERT_EQ(result.width, width);
    ASSERT_EQ(result.height, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c) {
          ASSERT_NEAR(static_cast<double>(result.at(x, y, c)),
                      mean_of_area(image, x, y, c, width, height), 1e-6)
              << width << "x" << height << " at " << x << "," << y;
        }
      }
    }
  }
}

TEST(ImageMetrics, do_not_depend_on_the_number_of_threads) {
  const Image a = noise(160, 130, 3, 5), b = noise(160, 130, 3, 6);
  ThreadPool one(1), many(7);
  EXPECT_EQ(psnr(a, b, one), psnr(a, b, many));
  EXPECT_EQ(ssim(a, b, one), ssim(a, b, many));
  EXPECT_EQ(area_average(a, 47, 33, one).values, area_average(a, 47, 33, many).values);
}

TEST(ImageMetrics, clamping_removes_what_no_picture_can_hold) {
  Image image(4, 1, 1);
  image.values = {-1, 0.25f, 7, NAN};
  clamp_to_unit(image);
  EXPECT_EQ(image.values, (std::vector<float>{0, 0.25f, 1, 0}));
}

}  // namespace
}  // namespace qs
