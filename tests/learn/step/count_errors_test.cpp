// SPDX-License-Identifier: MIT
// The pixels per Gaussian that several views get wrong, against a walk over every pixel.

#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <gtest/gtest.h>

#include "learn/gradient/error_map.h"
#include "learn/step/cpu/passes.h"
#include "learn/step/training_model.h"
#include "raster/kernel/composite.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/train_scenes.h"

namespace qs::cpu::train {
namespace {

using test::kHeight;
using test::kWidth;
using test::pool;
using test::small_scene;

using Histogram = std::array<std::uint32_t, kErrorBins>;

TEST(ErrorMap, bins_hold_the_mean_error_of_the_channels) {
  const glm::vec3 gray(0.5f);
  EXPECT_EQ(error_bin(gray, gray), 0);
  EXPECT_EQ(error_bin({1, 1, 1}, {0, 0, 0}), kErrorBins - 1);
  EXPECT_EQ(error_bin({0.8f, 0.5f, 0.5f}, gray), 102) << "0.1 of 1024";
  EXPECT_EQ(error_bin({0.5f, 0.5f, 0.2f}, gray), 102) << "the sign does not matter";
  EXPECT_EQ(error_bin({2, 2, 2}, {1, 1, 1}), 0) << "as it is shown";
  EXPECT_EQ(error_bin({NAN, 0, 0}, gray), kErrorBins - 1);
  EXPECT_EQ(error_bin({INFINITY, 0, 0}, gray), 512);
}

TEST(ErrorMap, the_limit_is_a_quarter_of_the_largest_errors_but_for_one_percent) {
  Histogram histogram{};
  EXPECT_EQ(error_limit(histogram.data()), 0) << "no pixel";
  histogram[0] = 1000;
  EXPECT_EQ(error_limit(histogram.data()), 0) << "equal pictures";
  histogram[400] = 500;
  EXPECT_EQ(error_limit(histogram.data()), 100);
  histogram[1023] = 15;
  EXPECT_EQ(error_limit(histogram.data()), 100) << "few bad pixels do not move it";
  histogram[1023] = 16;
  EXPECT_EQ(error_limit(histogram.data()), 255);
}

TEST(ErrorMap, the_limit_does_not_depend_on_the_number_of_pixels) {
  Histogram small{}, large{};
  for (unsigned bin = 0; bin < 600; ++bin) {
    small[bin] = 600 - bin;
    large[bin] = 16 * small[bin];
  }
  EXPECT_EQ(error_limit(large.data()), error_limit(small.data()));
}

/// A drawn view and a target whose left half is far from it.
struct Case {
  Parameters<float> scene = small_scene<float>(150, 4);
  Camera camera = test::front_camera(kWidth, kHeight);
  RenderSettings settings = test::settings_of(default_mode(), false);
  ForwardFrame<float> frame;
  std::vector<glm::vec3> target;

  explicit Case(CullMode mode = default_mode(), int threads = 2) {
    settings.mode = mode;
    scene.means[3].z = -1;  // in no view
    forward(view(threads), scene, frame);
    for (std::size_t i = 0; i < frame.color.size(); ++i) {
      const bool left = i % kWidth < kWidth / 2;
      target.push_back(glm::clamp(frame.color[i], 0.0f, 1.0f) * (left ? 0.2f : 0.98f));
    }
  }
  StepView view(int threads = 2) const { return {camera, settings, pool(threads)}; }
  PixelCounts counts(std::span<const std::uint8_t> mask = {}, int threads = 2) const {
    PixelCounts result;
    count_errors(view(threads), frame, target, mask, scene.size(), result);
    return result;
  }
};

// Walks the whole list of every pixel.
PixelCounts expected_counts(const Case& c, std::span<const std::uint8_t> mask) {
  PixelCounts counts{std::vector<std::uint32_t>(c.scene.size()),
                     std::vector<std::uint32_t>(c.scene.size())};
  Histogram histogram{};
  const auto counted = [&](std::size_t at) { return mask.empty() || mask[at] != 0; };
  for (std::size_t at = 0; at < c.target.size(); ++at)
    if (counted(at)) ++histogram[error_bin(c.frame.color[at], c.target[at])];
  const unsigned limit = error_limit(histogram.data());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto at = static_cast<std::size_t>(y * kWidth + x);
      if (!counted(at)) continue;
      const auto tile =
          static_cast<std::size_t>(y / kTileSize * c.view().grid().columns + x / kTileSize);
      float transmittance = 1, alpha = 0;
      for (std::uint32_t k = 0; k < c.frame.lists.pairs(tile); ++k) {
        const std::uint32_t slot = c.frame.lists.slots[c.frame.lists.begin[tile] + k];
        const Step step = composite(c.frame.splats[slot], static_cast<float>(x),
                                    static_cast<float>(y), transmittance, alpha);
        if (step == Step::stops) break;
        if (step == Step::skips) continue;
        ++counts.blended[c.frame.visible.gaussians[slot]];
        if (error_bin(c.frame.color[at], c.target[at]) > limit)
          ++counts.flagged[c.frame.visible.gaussians[slot]];
      }
    }
  }
  return counts;
}

TEST(CountErrors, counts_the_pixels_that_blend_a_gaussian_and_the_wrong_ones_among_them) {
  const Case c;
  std::vector<std::uint8_t> mask(c.target.size(), 1);
  for (std::size_t i = 0; i < mask.size(); i += 3) mask[i] = 0;
  for (const auto& some : {std::vector<std::uint8_t>(), mask}) {
    const PixelCounts counts = c.counts(some), expected = expected_counts(c, some);
    EXPECT_EQ(counts.blended, expected.blended);
    EXPECT_EQ(counts.flagged, expected.flagged);
    EXPECT_EQ(counts.blended[3], 0u);
    EXPECT_EQ(counts.flagged_share(3), 0);
  }
  std::uint64_t blended = 0, flagged = 0;
  for (const std::uint32_t count : c.counts().blended) blended += count;
  for (const std::uint32_t count : c.counts().flagged) flagged += count;
  EXPECT_GT(flagged, blended / 4);
  EXPECT_LT(flagged, blended * 3 / 4);
}

TEST(CountErrors, threads_and_lossless_modes_do_not_change_the_counts) {
  const PixelCounts expected = Case().counts();
  EXPECT_EQ(Case().counts({}, 7).flagged, expected.flagged);
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    if (!row_of(mode).lossless) continue;
    EXPECT_EQ(Case(mode).counts().blended, expected.blended) << mode_name(mode);
    EXPECT_EQ(Case(mode).counts().flagged, expected.flagged) << mode_name(mode);
  }
}

TEST(CountErrors, the_model_adds_views_until_the_set_changes) {
  const auto model = qs::train::make_training_model(Backend::cpu, pool());
  const Case c;
  test::start(*model, c.scene);
  EXPECT_TRUE(model->facts().counts.blended.empty());
  const std::vector<std::uint8_t> black(3 * c.target.size());
  const auto count = [&] {
    model->forward(c.camera, c.settings);
    model->count_errors(std::nullopt, {black, {}, {}});
  };
  count();
  const std::vector<std::uint32_t> once = model->facts().counts.blended;
  count();
  const std::vector<std::uint32_t> twice = model->facts().counts.blended;
  ASSERT_EQ(twice.size(), c.scene.size());
  for (std::size_t i = 0; i < once.size(); ++i) EXPECT_EQ(twice[i], 2 * once[i]);
  qs::train::Plan plan;
  plan.keep_all(model->facts(), 2);
  model->apply(plan);
  EXPECT_TRUE(model->facts().counts.blended.empty());
}

}  // namespace
}  // namespace qs::cpu::train
