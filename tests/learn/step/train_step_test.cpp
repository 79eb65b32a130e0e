// SPDX-License-Identifier: MIT
// The loss and the optimizer of training, against differences and independent computations.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "learn/step/cpu/loss.h"
#include "learn/step/cpu/passes.h"
#include "raster/scene/image_metrics.h"
#include "support/differences.h"
#include "support/pool.h"

namespace qs::cpu::train {
namespace {

using test::pool;

template <class Real>
std::vector<glm::vec<3, Real>> random_picture(int width, int height, unsigned seed, double low = 0,
                                              double high = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(low, high);
  std::vector<glm::vec<3, Real>> picture(static_cast<std::size_t>(width * height));
  for (auto& pixel : picture) {
    for (int c = 0; c < 3; ++c)
      pixel[c] = static_cast<Real>(static_cast<float>(uniform(random)));  // the same in both
  }
  return picture;
}

Image image_of(int width, int height, const std::vector<glm::vec3>& picture) {
  Image image(width, height, 3);
  std::copy_n(&picture[0][0], image.values.size(), image.values.begin());
  return image;
}

template <class Real>
Loss loss_of(int width, int height, const std::vector<glm::vec<3, Real>>& picture,
             const std::vector<glm::vec3>& target, std::vector<glm::vec<3, Real>>& gradient,
             int threads = 2, std::span<const std::uint8_t> mask = {}) {
  SsimFields<Real> scratch;
  return compare<Real>({width, height, picture, target, mask}, pool(threads), scratch, gradient);
}

// Masks out a rectangle, and single pixels.
std::vector<std::uint8_t> some_mask(int width, int height) {
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(width * height), 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if ((x < width / 3 && y > height / 2) || (x + 5 * y) % 7 == 0)
        mask[static_cast<std::size_t>(y * width + x)] = 0;
    }
  }
  return mask;
}

TEST(TrainLoss, is_made_of_the_metrics_that_eval_reports) {
  for (const auto& [width, height] : {std::pair{37, 23}, {5, 4}, {1, 30}}) {
    const auto picture = random_picture<float>(width, height, 1);
    const auto target = random_picture<float>(width, height, 2);
    std::vector<glm::vec3> gradient;
    const Loss loss = loss_of(width, height, picture, target, gradient);
    const Image a = image_of(width, height, picture), b = image_of(width, height, target);
    EXPECT_NEAR(loss.ssim, ssim(a, b, pool()), 1e-5);
    EXPECT_NEAR(psnr_of(loss.squared_error), psnr(a, b, pool()), 1e-9);
    double l1 = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i)
      l1 += std::abs(static_cast<double>(a.values[i]) - static_cast<double>(b.values[i]));
    EXPECT_NEAR(loss.l1, l1 / static_cast<double>(a.values.size()), 1e-7);  // differences in float
    EXPECT_NEAR(loss.total, 0.8 * loss.l1 + 0.2 * (1 - loss.ssim), 1e-12);
  }
}

class TrainLossGradient : public testing::TestWithParam<bool> {};

TEST_P(TrainLossGradient, equals_differences) {
  constexpr int kLossWidth = 14, kLossHeight = 13;  // wider than the window, so all weights matter
  const auto mask = GetParam() ? some_mask(kLossWidth, kLossHeight) : std::vector<std::uint8_t>();
  const auto target = random_picture<float>(kLossWidth, kLossHeight, 3);
  const auto picture = random_picture<double>(kLossWidth, kLossHeight, 4, -0.2, 1.2);
  const std::vector<double> x(&picture[0][0], &picture[0][0] + 3 * picture.size());
  const auto at = []<class Real>(const std::vector<Real>& values) {
    std::vector<glm::vec<3, Real>> pixels(values.size() / 3);
    std::copy(values.begin(), values.end(), &pixels[0][0]);
    return pixels;
  };
  std::vector<glm::dvec3> ignored;
  const auto expected = test::differences(
      [&](const auto& values) {
        return loss_of(kLossWidth, kLossHeight, at(values), target, ignored, 1, mask).total;
      },
      x, 1e-6);
  const auto gradient = [&]<class Real>(const std::vector<Real>& values) {
    std::vector<glm::vec<3, Real>> result;
    loss_of(kLossWidth, kLossHeight, at(values), target, result, 2, mask);
    return std::vector<Real>(&result[0][0], &result[0][0] + 3 * result.size());
  };
  test::expect_close(gradient(x), expected, 1e-6);
  test::expect_close(gradient(std::vector<float>(x.begin(), x.end())), expected, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(TrainLoss, TrainLossGradient, testing::Bool(),
                         [](const auto& row) { return row.param ? "masked" : "whole"; });

TEST(TrainLoss, of_masked_pictures_is_made_of_masked_metrics) {
  constexpr int kLossWidth = 37, kLossHeight = 23;
  const auto picture = random_picture<float>(kLossWidth, kLossHeight, 1);
  const auto target = random_picture<float>(kLossWidth, kLossHeight, 2);
  const auto mask = some_mask(kLossWidth, kLossHeight);
  std::vector<glm::vec3> gradient;
  const Loss loss = loss_of(kLossWidth, kLossHeight, picture, target, gradient, 2, mask);
  const Image a = image_of(kLossWidth, kLossHeight, picture),
              b = image_of(kLossWidth, kLossHeight, target);
  EXPECT_NEAR(loss.ssim, ssim(a, b, pool(), SsimBorder::zeros, mask), 1e-5);
  EXPECT_NEAR(psnr_of(loss.squared_error), psnr(a, b, pool(), mask), 1e-9);
  double l1 = 0, counted = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] == 0) continue;
    for (int c = 0; c < 3; ++c, ++counted)
      l1 += std::abs(static_cast<double>(picture[i][c]) - static_cast<double>(target[i][c]));
  }
  EXPECT_NEAR(loss.l1, l1 / counted, 1e-7);
}

TEST(TrainLoss, compares_the_picture_as_it_is_shown) {
  constexpr int kLossWidth = 37, kLossHeight = 23;
  const auto picture = random_picture<float>(kLossWidth, kLossHeight, 1, -0.2, 1.2);
  const auto target = random_picture<float>(kLossWidth, kLossHeight, 2);
  auto shown_picture = picture;
  for (glm::vec3& pixel : shown_picture) pixel = glm::clamp(pixel, 0.0f, 1.0f);
  std::vector<glm::vec3> gradient, expected;
  const Loss loss = loss_of(kLossWidth, kLossHeight, picture, target, gradient);
  EXPECT_EQ(loss.total, loss_of(kLossWidth, kLossHeight, shown_picture, target, expected).total);
  for (std::size_t i = 0; i < picture.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const bool inside = picture[i][c] == shown_picture[i][c];
      EXPECT_EQ(gradient[i][c], inside ? expected[i][c] : 0.0f);
    }
  }
}

TEST(TrainLoss, under_a_mask_nothing_matters_and_nothing_has_a_gradient) {
  constexpr int kLossWidth = 37, kLossHeight = 23;
  auto picture = random_picture<float>(kLossWidth, kLossHeight, 1);
  auto target = random_picture<float>(kLossWidth, kLossHeight, 2);
  const auto mask = some_mask(kLossWidth, kLossHeight);
  std::vector<glm::vec3> gradient, other, whole;
  const Loss loss = loss_of(kLossWidth, kLossHeight, picture, target, gradient, 2, mask);
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] != 0) continue;
    EXPECT_EQ(gradient[i], glm::vec3(0));
    picture[i] *= -3;
    target[i] += glm::vec3(1, 0.5f, 0);
  }
  EXPECT_EQ(loss_of(kLossWidth, kLossHeight, picture, target, other, 2, mask).total, loss.total);
  EXPECT_EQ(other, gradient);
  const std::vector<std::uint8_t> all(mask.size(), 1);
  EXPECT_EQ(loss_of(kLossWidth, kLossHeight, picture, target, other, 2, all).total,
            loss_of(kLossWidth, kLossHeight, picture, target, whole).total);
  EXPECT_EQ(other, whole);
}

TEST(TrainLoss, does_not_depend_on_the_number_of_threads) {
  const auto picture = random_picture<float>(61, 47, 5), target = random_picture<float>(61, 47, 6);
  std::vector<glm::vec3> one, several;
  const Loss expected = loss_of(61, 47, picture, target, one, 1);
  const Loss loss = loss_of(61, 47, picture, target, several, 5);
  EXPECT_EQ(loss.total, expected.total);
  EXPECT_EQ(several, one);
}

TEST(TrainLoss, of_equal_pictures_is_0_and_flat) {
  const auto picture = random_picture<float>(20, 20, 7);
  std::vector<glm::vec3> gradient;
  const Loss loss = loss_of(20, 20, picture, picture, gradient);
  EXPECT_NEAR(loss.total, 0, 1e-6);
  for (const glm::vec3& d : gradient) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(d[c], 0, 1e-7);
  }
}

TEST(TrainAdam, follows_the_published_rule_with_the_rate_of_each_kind) {
  Parameters<float> parameters;
  parameters.sh_degree = 1;
  parameters.has_masks = true;
  parameters.resize(3);
  AdamState state = AdamState::like(parameters);
  const Rates rates{1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3};
  std::mt19937 random(8);
  std::normal_distribution<float> normal;

  // Two values of each kind in double precision, by the text of the paper.
  struct Check {
    const char* name;
    double rate;
    std::function<float&(Parameters<float>&)> value;
    double expected = 0, m = 0, v = 0;
  };
  std::vector<Check> checks = {
      {"mean", 1e-3, [](auto& p) -> float& { return p.means[2].y; }},
      {"log scale", 2e-3, [](auto& p) -> float& { return p.log_scales[0].z; }},
      {"rotation", 3e-3, [](auto& p) -> float& { return p.rotations[1].w; }},
      {"opacity", 4e-3, [](auto& p) -> float& { return p.opacity_logits[2]; }},
      {"sh dc", 5e-3, [](auto& p) -> float& { return p.sh[4].x; }},
      {"sh rest", 6e-3, [](auto& p) -> float& { return p.sh[7].y; }},
      {"mask", 7e-3, [](auto& p) -> float& { return p.mask_logits[1]; }},
  };
  for (int t = 1; t <= 200; ++t) {
    Gradients<float> gradients;
    gradients.reset(parameters);
    for (Check& check : checks) {
      const float g = 1e-4f * (0.3f + normal(random));
      check.value(gradients.by) = g;
      check.m = 0.9 * check.m + 0.1 * static_cast<double>(g);
      check.v = 0.999 * check.v + 0.001 * static_cast<double>(g) * static_cast<double>(g);
      const double m_hat = check.m / (1 - std::pow(0.9, t));
      const double v_hat = check.v / (1 - std::pow(0.999, t));
      check.expected -= check.rate * m_hat / (std::sqrt(v_hat) + 1e-15);
    }
    take_step(parameters, gradients.by, rates, state, pool());
  }
  for (Check& check : checks) {
    EXPECT_NEAR(check.value(parameters), check.expected, 1e-4 * std::abs(check.expected))
        << check.name;
  }
  EXPECT_EQ(parameters.means[0], glm::vec3(0)) << "without a gradient nothing moves";
  EXPECT_EQ(state.steps, 200u);
}

TEST(TrainAdam, never_lets_a_gradient_that_is_not_finite_into_a_parameter) {
  Parameters<float> parameters;
  parameters.resize(1);
  AdamState state = AdamState::like(parameters);
  Gradients<float> gradients;
  gradients.reset(parameters);
  const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f};
  for (const float g : bad) {
    gradients.by.means[0] = glm::vec3(g);
    gradients.by.opacity_logits[0] = g;
    take_step(parameters, gradients.by, {1, 1, 1, 1, 1, 1}, state, pool());
  }
  EXPECT_TRUE(std::isfinite(parameters.means[0].x));
  EXPECT_TRUE(std::isfinite(parameters.opacity_logits[0]));
}

TEST(TrainMaskWeights, the_weight_of_the_mean_mask_has_the_gradient_of_differences) {
  for (const double logit : {-4.0, -0.5, 1.0, 6.0}) {
    const auto loss = [](const std::vector<double>& x) { return 3 * opacity_of(x[0]) / 5; };
    EXPECT_NEAR(mask_weight_gradient(3, 5, static_cast<float>(logit)),
                test::differences(loss, {logit})[0], 1e-7);
  }
}

TEST(TrainMaskWeights, a_mask_is_out_where_its_sigmoid_is_at_most_a_hundredth) {
  EXPECT_FALSE(masked_out(static_cast<double>(kFirstMaskLogit)));
  EXPECT_NEAR(opacity_of(static_cast<double>(kMaskedOutLogit)), 0.01, 1e-8);
  EXPECT_TRUE(masked_out(static_cast<double>(kMaskedOutLogit)));
  EXPECT_FALSE(masked_out(-4.5951));
  EXPECT_TRUE(masked_out(-4.5952));
  EXPECT_TRUE(masked_out(-INFINITY));
  EXPECT_TRUE(masked_out(static_cast<double>(NAN)));
}

TEST(TrainDensity, averages_the_gradient_over_the_views_that_showed_a_gaussian) {
  DensityStatistics density;
  density.reset(3);
  Gradients<float> gradients;
  gradients.visible = {1, 1, 0};
  gradients.mean_px = {{3e-3f, 0}, {0, 1e-3f}, {5, 5}};
  add_view(gradients, gradients.visible, 200, 100, density);
  gradients.visible = {1, 0, 0};
  gradients.mean_px = {{0, 2e-3f}, {7, 7}, {5, 5}};
  add_view(gradients, gradients.visible, 200, 100, density);
  EXPECT_FLOAT_EQ(density.mean(0), 0.5f * (100 * 3e-3f + 50 * 2e-3f));
  EXPECT_FLOAT_EQ(density.mean(1), 50 * 1e-3f);
  EXPECT_EQ(density.mean(2), 0);
  EXPECT_TRUE(density.absolute.empty());
  EXPECT_EQ(density.mean_absolute(0), 0);
}

TEST(TrainDensity, averages_absolute_gradients_that_were_summed) {
  DensityStatistics density;
  density.reset(3);
  Gradients<float> gradients;
  gradients.visible = {1, 1, 0};
  gradients.mean_px = {{0, 0}, {0, 0}, {0, 0}};
  gradients.absolute_px = {{3e-3f, 0}, {NAN, 1e-3f}, {5, 5}};
  add_view(gradients, gradients.visible, 200, 100, density);
  gradients.absolute_px = {{0, 2e-3f}, {0, 2e-3f}, {5, 5}};
  add_view(gradients, gradients.visible, 200, 100, density);
  EXPECT_FLOAT_EQ(density.mean_absolute(0), 0.5f * (100 * 3e-3f + 50 * 2e-3f));
  EXPECT_FLOAT_EQ(density.mean_absolute(1), 0.5f * 50 * 2e-3f) << "NaN adds nothing";
  EXPECT_EQ(density.mean_absolute(2), 0);
  density.reset(2);
  EXPECT_TRUE(density.absolute.empty());
}

}  // namespace
}  // namespace qs::cpu::train
