// SPDX-License-Identifier: MIT
// Training on synthetic views: it finds the scene again, and repeats itself to the bit.
#include <gtest/gtest.h>

#include "app/train/checkpoint.h"
#include "app/train/trainer.h"
#include "app/training.h"
#include "support/pool.h"
#include "support/temporary_folder.h"

namespace qs::train {
namespace {

using test::pool;

constexpr std::size_t kGaussians = 200;
constexpr int kViews = 16;  // 12 for training

const DataSet& synthetic() {
  static const DataSet data = test::data_set_of(test::ball_of_gaussians(kGaussians, 1), kViews);
  return data;
}

/// A run whose iteration `last` is over.
Trainer perturbed_trainer(const TrainSettings& settings, int threads = 0, int last = 0) {
  ModelState model =
      ModelState::starting_with(test::perturbed(test::ball_of_gaussians(kGaussians, 1), 2));
  model.iteration = last;
  return {settings, synthetic(), std::move(model), pool(threads)};
}

TrainSettings flat_colours() {
  TrainSettings settings;
  settings.sh_degree = 0;
  return settings;
}

template <class T>
void expect_same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(T)), 0);
}

void expect_same(const ModelState& a, const ModelState& b) {
  EXPECT_EQ(a.iteration, b.iteration);
  EXPECT_EQ(a.adam.steps, b.adam.steps);
  const auto same = [](std::size_t, const auto& x, const auto& y) { expect_same_bits(x, y); };
  cpu::train::for_each_array(same, a.parameters, b.parameters);
  cpu::train::for_each_array(same, a.adam.first, b.adam.first);
  cpu::train::for_each_array(same, a.adam.second, b.adam.second);
  expect_same_bits(a.density.sums, b.density.sums);
  expect_same_bits(a.density.views, b.density.views);
}

TEST(TrainFit, perturbed_gaussians_return_to_35_db_on_views_that_they_were_not_fitted_to) {
  ASSERT_EQ(synthetic().training.size(), 12u);
  TrainSettings settings = flat_colours();
  settings.max_gaussians = kGaussians;
  Trainer trainer = perturbed_trainer(settings);
  EXPECT_LE(trainer.test_quality()->psnr, 20);
  while (trainer.model().iteration < 1400) trainer.step();
  EXPECT_LE(trainer.model().size(), kGaussians);
  EXPECT_GE(trainer.test_quality()->psnr, 35);
}

TEST(TrainFit, what_masks_hide_changes_neither_the_model_nor_its_measures) {
  const auto masked = [](std::uint8_t hidden) {
    DataSet data = synthetic();
    for (auto* views : {&data.training, &data.test}) {
      for (PhotographView& view : *views) {
        view.mask.assign(view.rgb.size() / 3, 1);
        for (std::size_t i = 0; i < view.mask.size(); i += 1 + i % 5) {
          view.mask[i] = 0;
          std::fill_n(&view.rgb[3 * i], 3, hidden);
        }
      }
    }
    return data;
  };
  const DataSet dark = masked(0), bright = masked(255);
  const auto start = [] {
    return ModelState::starting_with(test::perturbed(test::ball_of_gaussians(kGaussians, 1), 2));
  };
  Trainer a(flat_colours(), dark, start(), pool()), b(flat_colours(), bright, start(), pool());
  for (int i = 0; i < 20; ++i) EXPECT_EQ(a.step().loss.total, b.step().loss.total);
  expect_same(a.model(), b.model());
  EXPECT_EQ(a.test_quality()->psnr, b.test_quality()->psnr);
  EXPECT_EQ(a.test_quality()->ssim, b.test_quality()->ssim);
}

class TrainStrategy : public testing::TestWithParam<const char*> {
 protected:
  static TrainSettings settings() {
    TrainSettings settings = flat_colours();
    settings.strategy = GetParam();
    settings.max_gaussians = 260;
    settings.seed = 3;
    return settings;
  }
};

// Over iteration 600, after which Gaussians are added and removed.
constexpr int kStart = 580;

TEST_P(TrainStrategy, a_resumed_run_and_other_threads_give_the_same_bits) {
  constexpr int kBreak = 601, kEnd = 610;
  Trainer whole = perturbed_trainer(settings(), 1, kStart);
  while (whole.model().iteration < kEnd) whole.step();
  EXPECT_NE(whole.model().size(), kGaussians) << "the set of Gaussians changed";

  Trainer first = perturbed_trainer(settings(), 3, kStart);
  while (first.model().iteration < kBreak) first.step();
  const TemporaryFolder folder;
  write_checkpoint({settings(), "data", {}, first.model()}, folder / "checkpoint");
  Checkpoint read = read_checkpoint(folder / "checkpoint");
  expect_same(read.model, first.model());
  Trainer second(read.settings, synthetic(), std::move(read.model), pool(2));
  while (second.model().iteration < kEnd) second.step();
  expect_same(second.model(), whole.model());
}

TEST_P(TrainStrategy, all_lossless_culling_modes_give_the_same_bits) {
  constexpr int kEnd = 605;
  std::optional<ModelState> expected;
  for (const char* mode : {"adr", "exact"}) {
    TrainSettings with_mode = settings();
    with_mode.mode = find_culler(mode);
    Trainer trainer = perturbed_trainer(with_mode, 0, kStart);
    while (trainer.model().iteration < kEnd) trainer.step();
    if (!expected) expected = trainer.model();
    expect_same(trainer.model(), *expected);
  }
}

TEST_P(TrainStrategy, another_seed_gives_another_model) {
  TrainSettings other = settings();
  other.seed = 4;
  Trainer a = perturbed_trainer(settings()), b = perturbed_trainer(other);
  for (int i = 0; i < 5; ++i) a.step(), b.step();
  EXPECT_NE(a.model().parameters.means, b.model().parameters.means);
}

INSTANTIATE_TEST_SUITE_P(TrainFit, TrainStrategy, testing::Values("adc", "mcmc"),
                         [](const auto& row) { return std::string(row.param); });

}  // namespace
}  // namespace qs::train
