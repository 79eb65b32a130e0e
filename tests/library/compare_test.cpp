// SPDX-License-Identifier: MIT
// The library's metrics of two pictures are the program's.
#include <cmath>
#include <limits>
#include <random>

#include "library/opened_scene.h"
#include "raster/scene/image_metrics.h"
#include "support/lpips_weights.h"
#include "support/pool.h"
#include "support/safetensors.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

constexpr std::uint32_t kAll =
    QS_METRIC_PSNR | QS_METRIC_PSNR_8BIT | QS_METRIC_SSIM | QS_METRIC_FLIP;

Image noise(unsigned seed, int width = 41, int height = 23) {
  std::mt19937 random(seed);
  Image image(width, height, 3);
  for (float& value : image.values) value = static_cast<float>(random() % 1201) / 1000 - 0.1f;
  return image;
}

QsArray array_of(Image& image) {
  return quadsplat::array_of(image.values.data(), {image.height, image.width, 3});
}

QsComparison asked(std::uint32_t metrics) {
  auto comparison = quadsplat::sized<QsComparison>();
  comparison.metrics = metrics;
  return comparison;
}

TEST(LibraryCompare, computes_the_metrics_of_the_program) {
  quadsplat::Context context = test::cpu();
  Image a = noise(1), b = noise(2);
  const QsComparison found = context.compare(array_of(a), array_of(b), asked(kAll));
  QsComparison cropped = asked(QS_METRIC_SSIM);
  cropped.ssim_border = QS_BORDER_CROP;
  cropped = context.compare(array_of(a), array_of(b), cropped);
  clamp_to_unit(a);
  clamp_to_unit(b);
  ThreadPool& pool = test::pool();
  EXPECT_EQ(found.psnr, psnr(a, b, pool));
  EXPECT_EQ(found.psnr_8bit, psnr_8bit(a, b));
  EXPECT_EQ(found.ssim, ssim(a, b, pool));
  EXPECT_EQ(found.flip, flip(a, b, pool));
  EXPECT_EQ(cropped.ssim, ssim(a, b, pool, SsimBorder::crop));
  EXPECT_EQ(cropped.psnr, 0);
}

TEST(LibraryCompare, leaves_out_masked_pixels) {
  quadsplat::Context context = test::cpu();
  Image a = noise(1), b = noise(2);
  std::vector<std::uint8_t> mask(41 * 23);
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = i % 3 == 0 ? 0 : 255;
  QsComparison comparison = asked(QS_METRIC_PSNR | QS_METRIC_SSIM);
  comparison.mask = quadsplat::array_of(mask.data(), {23, 41});
  comparison = context.compare(array_of(a), array_of(b), comparison);
  clamp_to_unit(a);
  clamp_to_unit(b);
  EXPECT_EQ(comparison.psnr, psnr(a, b, test::pool(), mask));
  EXPECT_EQ(comparison.ssim, ssim(a, b, test::pool(), SsimBorder::zeros, mask));
}

TEST(LibraryCompare, reads_bytes_doubles_and_planes) {
  quadsplat::Context context = test::cpu();
  Image a = noise(1);
  clamp_to_unit(a);
  std::vector<std::uint8_t> bytes;
  for (const float value : a.values) bytes.push_back(to_8bit(value));
  std::vector<double> planes(a.values.size());
  for (int y = 0; y < 23; ++y)
    for (int x = 0; x < 41; ++x)
      for (int c = 0; c < 3; ++c)
        planes[static_cast<std::size_t>((c * 23 + y) * 41 + x)] =
            static_cast<double>(a.at(x, y, c));
  const QsArray of_planes = quadsplat::planes_of(planes.data(), 23, 41);
  const QsArray of_bytes = quadsplat::array_of(bytes.data(), {23, 41, 3});
  const QsComparison same = context.compare(array_of(a), of_planes, asked(kAll));
  EXPECT_EQ(same.psnr, std::numeric_limits<double>::infinity());
  EXPECT_EQ(same.ssim, 1);
  EXPECT_EQ(same.flip, 0);
  const QsComparison rounded = context.compare(array_of(a), of_bytes, asked(kAll));
  EXPECT_EQ(rounded.psnr_8bit, std::numeric_limits<double>::infinity());
  EXPECT_GT(rounded.psnr, 55);
  EXPECT_TRUE(std::isfinite(rounded.psnr));
}

TEST(LibraryCompare, takes_nan_as_0_and_a_single_pixel) {
  quadsplat::Context context = test::cpu();
  float a[] = {std::numeric_limits<float>::quiet_NaN(), 1, 2}, b[] = {0, 1, 1};
  const QsComparison found = context.compare(quadsplat::array_of(a, {1, 1, 3}),
                                             quadsplat::array_of(b, {1, 1, 3}), asked(kAll));
  EXPECT_EQ(found.psnr, std::numeric_limits<double>::infinity());
  EXPECT_EQ(found.flip, 0);
}

TEST(LibraryCompare, computes_lpips_for_both_ranges_of_the_network_s_input) {
  const TemporaryFolder folder;
  const lpips::Weights weights = test::golden_weights(lpips::kNetworks[1]);
  const std::string file = (folder / "alexnet.safetensors").string();
  test::write_lpips_weights(weights, file);
  quadsplat::Context context = test::cpu();
  auto [a, b] = test::golden_pictures(70, 65);
  QsComparison comparison = asked(QS_METRIC_LPIPS | QS_METRIC_LPIPS_PAPER);
  comparison.lpips_weights = file.c_str();
  const QsComparison found = context.compare(array_of(a), array_of(b), comparison);
  const lpips::Metric metric(weights);
  EXPECT_EQ(found.lpips, metric.distance(a, b, lpips::InputRange::symmetric, test::pool()));
  EXPECT_EQ(found.lpips_paper, metric.distance(a, b, lpips::InputRange::unit, test::pool()));
  EXPECT_NE(found.lpips, found.lpips_paper);
  comparison.metrics = QS_METRIC_LPIPS;
  const QsComparison same = context.compare(array_of(a), array_of(a), comparison);
  EXPECT_EQ(same.lpips, 0);
  EXPECT_EQ(same.lpips_paper, 0);
  const auto refused = [&](Image& first, Image& second, std::int32_t code = QS_USAGE) {
    return test::sentence_of(
        [&] { context.compare(array_of(first), array_of(second), comparison); }, code);
  };
  Image small = noise(1, 20, 40);
  const std::string side = std::to_string(lpips::smallest_side(*weights.network));
  EXPECT_EQ(refused(small, small),
            "qs_compare: a: has 20 x 40 pixels, and LPIPS with alexnet needs " + side + " x " +
                side + " at least");
  const std::string missing = (folder / "missing.safetensors").string();
  comparison.lpips_weights = missing.c_str();
  EXPECT_EQ(refused(a, b, QS_INPUT).find(missing), 0u);
  comparison.lpips_weights = nullptr;
  EXPECT_EQ(refused(a, b), "qs_compare: comparison.lpips_weights: is null");
}

}  // namespace
}  // namespace qs
