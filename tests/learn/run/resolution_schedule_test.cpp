// SPDX-License-Identifier: MIT
// Training with reduced photographs: frequencies, the schedule of factors, and the filters. Golden
// numbers were computed from DashGaussian's published rules with numpy's transform.
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "learn/run/photograph_cache.h"
#include "learn/run/schedule.h"
#include "learn/run/spectrum.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs::train {
namespace {

using test::pool;
using testing::DoubleNear;
using testing::Each;
using testing::ElementsAre;

// Picture n of the golden schedule: waves and a regular noise, with 8 bits.
Image golden_picture(int n) {
  constexpr int kWidth = 48, kHeight = 32;
  Image picture(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) {
        const int k = ((n * 3 + c) * kHeight + y) * kWidth + x + 1;
        const double turns = k * 0.6180339887498949, noise = turns - std::floor(turns);
        const double wave = std::sin(2 * std::numbers::pi * (n + 1) * x / kWidth) *
                            std::cos(2 * std::numbers::pi * y / kHeight);
        const double value = 0.5 + 0.3 * wave + 0.1 * (noise - 0.5);
        picture.at(x, y, c) = static_cast<float>(std::floor(255 * value + 0.5) / 255);
      }
    }
  }
  return picture;
}

ResolutionSchedule golden_schedule(int end = 27'000) {
  PhotographSpectra spectra;
  for (int n = 0; n < 2; ++n) spectra.add(golden_picture(n), pool());
  return {spectra, end};
}

TEST(Fourier, equals_its_definition_for_lengths_of_every_kind) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Fourier::Work work;
  for (const std::size_t length : {1u, 2u, 3u, 8u, 30u, 37u, 64u, 101u}) {
    std::vector<double> re(length), im(length);
    for (std::size_t j = 0; j < length; ++j) re[j] = uniform(random), im[j] = uniform(random);
    std::vector<std::complex<double>> expected(length);
    for (std::size_t k = 0; k < length; ++k) {
      for (std::size_t j = 0; j < length; ++j)
        expected[k] += std::complex(re[j], im[j]) *
                       std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(j * k % length) /
                                           static_cast<double>(length));
    }
    Fourier(length).transform(re.data(), im.data(), work);
    for (std::size_t k = 0; k < length; ++k)
      EXPECT_LT(std::abs(std::complex(re[k], im[k]) - expected[k]), 1e-12) << length;
  }
}

TEST(Spectrum, a_wave_is_at_its_frequency_and_the_mean_in_the_middle) {
  for (const auto& [width, height] : {std::pair(16, 10), {15, 9}, {1, 1}}) {
    Image picture(width, height, 3);
    const int wave = width > 1 ? 3 : 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c)
          picture.at(x, y, c) = static_cast<float>(
              2 + (c + 1) * std::cos(2 * std::numbers::pi * wave * x / width) * (wave > 0));
      }
    }
    const Spectrum spectrum = Spectrum::of(picture, pool());
    const int pixels = width * height;
    const auto at = [&](int x, int y) {
      return spectrum
          .magnitudes[static_cast<std::size_t>((y + height / 2) * width + x + width / 2)];
    };
    EXPECT_NEAR(at(0, 0), 3 * 2 * pixels, 1e-4);
    if (wave == 0) continue;
    EXPECT_NEAR(at(wave, 0), (1 + 2 + 3) * pixels / 2, 1e-4);
    EXPECT_NEAR(at(-wave, 0), (1 + 2 + 3) * pixels / 2, 1e-4);
    EXPECT_NEAR(at(1, 1), 0, 1e-4);
    const SpectrumSums sums(spectrum);
    EXPECT_NEAR(sums.total(),
                std::accumulate(spectrum.magnitudes.begin(), spectrum.magnitudes.end(), 0.0), 1e-6);
    EXPECT_NEAR(sums.within(4), 3 * 2 * pixels, 1e-4) << "a wave of 5 pixels is gone";
  }
}

TEST(ResolutionSchedule, has_the_published_factors) {
  PhotographSpectra spectra;
  for (int n = 0; n < 2; ++n) spectra.add(golden_picture(n), pool());
  const std::vector<SpectrumSums> means = spectra.means();
  ASSERT_EQ(means.size(), 1u);
  EXPECT_NEAR(means[0].total(), 6033.999058, 1e-3);
  EXPECT_NEAR(means[0].within(8), 3699.467318, 1e-3);

  const ResolutionSchedule schedule = golden_schedule();
  const auto first = [](const auto& all) { return std::vector(all.begin(), all.begin() + 5); };
  EXPECT_THAT(first(schedule.scales()),
              ElementsAre(8, DoubleNear(3.428571, 1e-6), DoubleNear(2.666667, 1e-6),
                          DoubleNear(2.181818, 1e-6), DoubleNear(1.846154, 1e-6)));
  EXPECT_THAT(first(schedule.begins()), ElementsAre(0, 1112, 2202, 3271, 4320));
  EXPECT_EQ(schedule.begins().size(), 32u);
  EXPECT_EQ(schedule.begins()[30], 26'306);
  EXPECT_EQ(schedule.begins()[31], 27'000);
  EXPECT_EQ(schedule.details_from(), 3271);
  std::vector<int> factors;
  for (const int iteration : {1, 600, 1000, 2000, 5000, 27'000, 90'000})
    factors.push_back(schedule.factor_at(iteration));
  EXPECT_THAT(factors, ElementsAre(7, 4, 3, 2, 1, 1, 1));
}

TEST(ResolutionSchedule, factors_are_renewed_after_every_hundredth_iteration_from_600) {
  const ResolutionSchedule schedule = golden_schedule();
  EXPECT_EQ(schedule.factor_in(1), 7);
  EXPECT_EQ(schedule.factor_in(600), 7);
  EXPECT_EQ(schedule.factor_in(601), schedule.factor_at(600));
  EXPECT_EQ(schedule.factor_in(700), schedule.factor_at(600));
  EXPECT_EQ(schedule.factor_in(701), schedule.factor_at(700));
  int before = 7;
  for (int iteration = 1; iteration <= 27'001; ++iteration) {
    const int factor = schedule.factor_in(iteration);
    EXPECT_LE(factor, before);
    before = factor;
  }
  EXPECT_EQ(before, 1);
}

TEST(ResolutionSchedule, a_shorter_run_ends_in_full_size_too) {
  const ResolutionSchedule schedule = golden_schedule(900);
  EXPECT_EQ(schedule.factor_in(1), 7);
  EXPECT_EQ(schedule.factor_in(901), 1);
}

TEST(ResolutionSchedule, photographs_of_different_sizes_and_without_any_detail_have_one) {
  PhotographSpectra spectra;
  spectra.add(golden_picture(0), pool());
  Image small(20, 14, 3);
  for (std::size_t i = 0; i < small.values.size(); ++i)
    small.values[i] = 0.5f + 0.01f * static_cast<float>(i % 7);
  spectra.add(small, pool());
  EXPECT_EQ(spectra.means().size(), 2u);
  EXPECT_EQ(ResolutionSchedule(spectra, 27'000).factor_in(27'001), 1);

  for (const float gray : {0.0f, 0.5f}) {
    Image plain(160, 112, 3);
    std::fill(plain.values.begin(), plain.values.end(), gray);
    PhotographSpectra flat;
    flat.add(plain, pool());
    const ResolutionSchedule schedule(flat, 27'000);
    EXPECT_EQ(schedule.factor_in(1), 7);
    EXPECT_EQ(schedule.factor_in(27'001), 1);
  }
  EXPECT_EQ(ResolutionSchedule().factor_in(1), 1) << "no schedule: full size";
  EXPECT_EQ(ResolutionSchedule().details_from(), 0);
}

TEST(ReductionFilter, weighs_as_published) {
  const std::vector<double> row = {0, 1, 0, 0, 1, 1, 0, 1};
  const auto reduced_row = [&](ReductionFilter filter) {
    std::vector<double> result;
    for (int i = 0; i < 3; ++i) {
      const Taps taps = reduction_taps(8, 3, i, filter);
      double sum = 0;
      for (std::size_t k = 0; k < taps.weights.size(); ++k)
        sum += taps.weights[k] * row[static_cast<std::size_t>(taps.first) + k];
      result.push_back(sum);
    }
    return result;
  };
  EXPECT_THAT(reduced_row(ReductionFilter::triangle),
              ElementsAre(DoubleNear(0.394736842, 1e-9), DoubleNear(0.5, 1e-9),
                          DoubleNear(0.605263158, 1e-9)));
  EXPECT_THAT(reduced_row(ReductionFilter::lanczos2),
              ElementsAre(DoubleNear(0.345833419, 1e-9), DoubleNear(0.5, 1e-9),
                          DoubleNear(0.654166581, 1e-9)));
}

PhotographView view_of(int width, int height) {
  PhotographView view;
  view.camera = test::front_camera(width, height);
  view.rgb.resize(static_cast<std::size_t>(3 * width * height));
  for (std::size_t i = 0; i < view.rgb.size(); ++i)
    view.rgb[i] = static_cast<std::uint8_t>(40 * (i % 3) + 90);
  return view;
}

TEST(ReducedPhotographs, keep_the_field_of_view_and_plain_colours) {
  PhotographView view = view_of(17, 9);
  view.alpha.assign(17 * 9, 200);
  for (const auto filter : {ReductionFilter::triangle, ReductionFilter::lanczos2}) {
    const PhotographView half = reduced(view, 2, filter, pool());
    EXPECT_EQ(half.camera.width, 8);
    EXPECT_EQ(half.camera.height, 4);
    EXPECT_NEAR(half.camera.width / half.camera.focal_px.x, 17 / view.camera.focal_px.x, 1e-12);
    EXPECT_NEAR(half.camera.height / half.camera.focal_px.y, 9 / view.camera.focal_px.y, 1e-12);
    ASSERT_EQ(half.rgb.size(), 3u * 8 * 4);
    for (std::size_t i = 0; i < half.rgb.size(); ++i) EXPECT_EQ(half.rgb[i], 40 * (i % 3) + 90);
    EXPECT_EQ(half.alpha, std::vector<std::uint8_t>(8 * 4, 200));
    const PhotographView least = reduced(view, 100, filter, pool());
    EXPECT_EQ(least.camera.width, 1);
    EXPECT_EQ(least.camera.height, 1);
    EXPECT_EQ(least.rgb, (std::vector<std::uint8_t>{90, 130, 170}));
  }
}

TEST(ReducedPhotographs, a_pixel_counts_if_all_that_it_covers_counts) {
  PhotographView view = view_of(6, 2);
  view.mask = {1, 1, 1, 0, 1, 1,  //
               1, 1, 1, 1, 1, 1};
  EXPECT_THAT(reduced(view, 2, ReductionFilter::triangle, pool()).mask, ElementsAre(1, 0, 1));
  view.mask = {1, 0, 1, 0, 0, 0,  //
               1, 1, 0, 1, 0, 0};
  EXPECT_THAT(reduced(view, 2, ReductionFilter::triangle, pool()).mask, ElementsAre(1, 1, 0))
      << "else none would count";
}

TEST(ReducedPhotographs, views_are_made_once_per_factor) {
  const PhotographView a = view_of(8, 8), b = view_of(16, 8);
  ReducedPhotographs photographs(2, ReductionFilter::triangle, pool());
  EXPECT_FALSE(photographs.set_factor(1));
  EXPECT_TRUE(photographs.set_factor(4));
  EXPECT_FALSE(photographs.set_factor(4));
  const PhotographView* const kept = &photographs.view(0, a, true);
  EXPECT_EQ(kept->camera.width, 2);
  EXPECT_EQ(photographs.view(1, b, true).camera.width, 4);
  EXPECT_EQ(&photographs.view(0, b, true), kept) << "the number identifies it";
  EXPECT_EQ(photographs.view(0, b, false).camera.width, 4);
  EXPECT_TRUE(photographs.set_factor(2));
  EXPECT_EQ(photographs.view(0, a, true).camera.width, 4);
}

}  // namespace
}  // namespace qs::train
