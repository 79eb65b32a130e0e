// SPDX-License-Identifier: MIT
// Training on synthetic views: it finds the scene again, and repeats itself to the bit.
// Not in checked: whole trainings take minutes there; train_step_test.cpp runs the same code.
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/forwarding_model.h"
#include "app/support/training.h"
#include "base/fail.h"
#include "io/camera/lens_views.h"
#include "io/camera/photographs.h"
#include "learn/run/model_folder.h"
#include "learn/run/run.h"
#include "learn/run/trainer.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/temporary_folder.h"
#include "support/train_scenes.h"

namespace qs::train {
namespace {

using test::expect_same;

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
  return test::trainer_on(Backend::cpu, settings, synthetic(), std::move(model), threads);
}

TrainSettings flat_colours() {
  TrainSettings settings;
  settings.sh_degree = 0;
  return settings;
}

TEST(TrainFit, perturbed_gaussians_return_to_35_db_on_views_that_they_were_not_fitted_to) {
  ASSERT_EQ(synthetic().training.size(), 12u);
  TrainSettings settings = flat_colours();
  settings.max_gaussians = kGaussians;
  Trainer trainer = perturbed_trainer(settings);
  EXPECT_LE(trainer.test_quality()->psnr, 20);
  while (trainer.iteration() < 1400) trainer.step();
  EXPECT_LE(trainer.gaussians(), kGaussians);
  EXPECT_GE(trainer.test_quality()->psnr, 35);
}

// The counts of views differ only for Gaussians that one mode lists in a tile and `exact` does not.
TEST(TrainFit, views_count_by_the_rule_that_the_settings_name) {
  const auto views_of = [](const char* mode, CountViews count) {
    TrainSettings settings = flat_colours();
    settings.mode = find_culler(mode);
    settings.count_views = count;
    ModelState model = ModelState::starting_with(test::ball_of_gaussians(kGaussians, 1));
    model.parameters.opacity_logits[7] = -7;  // alpha < 1/255: `exact` does not list it
    Trainer trainer = test::trainer_on(Backend::cpu, settings, synthetic(), std::move(model));
    for (int i = 0; i < 12; ++i) trainer.step();
    return trainer.model().density.views;
  };
  const auto exact = views_of("3dgs", CountViews::exact),
             by_mode = views_of("3dgs", CountViews::mode);
  EXPECT_EQ(exact[7], 0u);
  EXPECT_EQ(by_mode[7], 12u);
  for (std::size_t i = 0; i < exact.size(); ++i) EXPECT_LE(exact[i], by_mode[i]) << i;
  EXPECT_EQ(views_of("exact", CountViews::mode), views_of("exact", CountViews::exact));
}

TEST(TrainFit, the_step_before_gaussians_are_added_is_taken_on_request) {
  const auto means_after_600 = [](bool step) {
    TrainSettings settings = flat_colours();
    settings.step_before_densify = step;
    Trainer trainer = perturbed_trainer(settings, 0, 599);
    trainer.step();
    return trainer.model().parameters.means;
  };
  const auto start = test::perturbed(test::ball_of_gaussians(kGaussians, 1), 2).means;
  EXPECT_EQ(means_after_600(false), start);
  EXPECT_NE(means_after_600(true), start);
}

TEST(TrainFit, the_opacity_rate_is_that_of_the_settings) {
  const auto first_move = [](double rate) {
    TrainSettings settings = flat_colours();
    settings.opacity_rate = rate;
    Trainer trainer = perturbed_trainer(settings);
    const float before = trainer.model().parameters.opacity_logits[0];
    trainer.step();
    return std::abs(trainer.model().parameters.opacity_logits[0] - before);
  };
  // Adam's first step is as long as the rate.
  EXPECT_NEAR(first_move(0), 0.025, 1e-4);
  EXPECT_NEAR(first_move(0.05), 0.05, 1e-4);
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
  Trainer a = test::trainer_on(Backend::cpu, flat_colours(), dark, start());
  Trainer b = test::trainer_on(Backend::cpu, flat_colours(), bright, start());
  for (int i = 0; i < 20; ++i) EXPECT_EQ(a.step().loss.total, b.step().loss.total);
  expect_same(a.model(), b.model());
  EXPECT_EQ(a.test_quality()->psnr, b.test_quality()->psnr);
  EXPECT_EQ(a.test_quality()->ssim, b.test_quality()->ssim);
}

// The photograph's lens sorts by distance and has one dilation all over: so has every face of it.
TEST(TrainFit, faces_of_a_photograph_are_drawn_as_it_is) {
  auto scene = test::small_scene<float>(500, 3);
  for (std::size_t i = 0; i < scene.size(); ++i)
    scene.means[i] = glm::vec3(kCubeAxes[i % kCubeAxes.size()] * glm::dvec3(scene.means[i]));
  const Lens lens{find_lens_model("FISHEYE"), {120, 120}, {60, 60}, {59.5, 59.5}};
  const LensCamera camera = lens_camera(lens, "test");
  RenderSettings through;
  through.sh_degree = 0;
  through.lens = std::make_shared<const LensView>(photograph_view(*camera.lens));
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(std::make_shared<const GaussianCloud>(to_cloud(scene, false)), {});
  const Image photograph = renderer->render(camera.taken(), through).color;
  DataSet data;
  for (const LensCamera& face : views_of(camera)) {
    const Image image = undistorted(photograph, face, test::pool());
    PhotographView view{face.camera, face.lens, {}, {}, {}, {}};
    std::ranges::transform(image.values, std::back_inserter(view.rgb), to_8bit);
    view.mask = lens_mask(face, image.width, image.height, test::pool());
    data.training.push_back(view);
    data.test.push_back(view);
  }
  ASSERT_EQ(data.test.size(), 5u);
  Trainer trainer =
      test::trainer_on(Backend::cpu, flat_colours(), data, ModelState::starting_with(scene));
  EXPECT_GE(trainer.test_quality()->psnr, 30);
}

// Runs out of memory in one iteration.
class FailingModel final : public test::ForwardingModel {
 public:
  FailingModel(int iteration, std::function<void()> fails)
      : fails_in_(iteration), fails_(std::move(fails)) {}

  void forward(const Camera& camera, const RenderSettings& settings,
               std::stop_token stop) override {
    if (iteration() + 1 == fails_in_) fails_();
    ForwardingModel::forward(camera, settings, std::move(stop));
  }

 private:
  int fails_in_;
  std::function<void()> fails_;
};

TEST(TrainRun, a_run_without_memory_is_saved_and_continues_to_the_same_bits) {
  TrainSettings settings = flat_colours();
  settings.iterations = 603;
  settings.strategy = "mcmc";
  RunOptions options;
  options.initial = test::perturbed(test::ball_of_gaussians(20, 1), 2);
  const auto run = [&](const std::filesystem::path& folder, bool resume,
                       std::unique_ptr<TrainingModel> model) {
    options.out_dir = folder;
    options.resume = resume;
    options.keep_checkpoint = true;
    return run_training(settings, synthetic(), options, std::move(model), test::pool());
  };
  const auto usual = [] { return make_training_model(Backend::cpu, test::pool()); };
  const TemporaryFolder folder;
  run(folder / "whole", false, usual());
  const Checkpoint whole = read_checkpoint(folder / "whole" / "checkpoint");
  EXPECT_EQ(whole.model.size(), 21u) << "it grew before iteration 601";
  std::vector<int> rows;
  for (const LogRow& row : whole.log.rows) rows.push_back(row.iteration);
  EXPECT_THAT(rows, testing::ElementsAre(100, 200, 300, 400, 500, 600, 603));

  // In iteration 601 the set of Gaussians has changed already.
  const std::function<void()> failures[] = {
      [] { throw std::bad_alloc(); },
      [] { throw Error(ErrorKind::device, "cuda: the step's pairs: 9 MiB are needed"); }};
  for (const int iteration : {40, 601}) {
    for (const auto& failure : failures) {
      const auto parts = folder / "parts";
      EXPECT_THAT(
          test::error_of(
              [&] { run(parts, false, std::make_unique<FailingModel>(iteration, failure)); },
              ErrorKind::device),
          testing::AllOf(testing::HasSubstr("the run was saved in " + parts.string()),
                         testing::HasSubstr(fmt::format("iteration {} ", iteration))));
      EXPECT_EQ(read_checkpoint(parts / "checkpoint").model.iteration, iteration - 1);
      run(parts, true, usual());
      expect_same(read_checkpoint(parts / "checkpoint").model, whole.model);
    }
  }
}

class TrainStrategy : public testing::TestWithParam<const char*> {
 protected:
  static TrainSettings settings() {
    TrainSettings settings = flat_colours();
    settings.strategy = GetParam();
    settings.max_gaussians = 260;
    settings.many_gaussians = true;      // read by fastgs
    settings.absolute_gradients = true;  // read by adc
    settings.seed = 3;
    return settings;
  }
};

// Beyond iteration 1,000, after which all strategies add and remove Gaussians.
constexpr int kStart = 980;

TEST_P(TrainStrategy, a_resumed_run_and_other_threads_give_the_same_bits) {
  constexpr int kBreak = 1001, kEnd = 1010;
  Trainer whole = perturbed_trainer(settings(), 1, kStart);
  while (whole.iteration() < kEnd) whole.step();
  EXPECT_NE(whole.gaussians(), kGaussians) << "the set of Gaussians changed";

  Trainer first = perturbed_trainer(settings(), 3, kStart);
  while (first.iteration() < kBreak) first.step();
  const TemporaryFolder folder;
  write_checkpoint({settings(), "data", {}, first.model()}, folder / "checkpoint");
  Checkpoint read = read_checkpoint(folder / "checkpoint");
  expect_same(read.model, first.model());
  Trainer second =
      test::trainer_on(Backend::cpu, read.settings, synthetic(), std::move(read.model), 2);
  while (second.iteration() < kEnd) second.step();
  expect_same(second.model(), whole.model());
}

TEST_P(TrainStrategy, all_lossless_culling_modes_give_the_same_bits) {
  constexpr int kEnd = 1005;
  std::optional<ModelState> expected;
  for (const char* mode : {"adr", "exact"}) {
    TrainSettings with_mode = settings();
    with_mode.mode = find_culler(mode);
    Trainer trainer = perturbed_trainer(with_mode, 0, kStart);
    while (trainer.iteration() < kEnd) trainer.step();
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

// Breaks with sums of the coefficients of colour only, and of all values; a change drops sums.
TEST(TrainFastgs, a_run_with_summed_gradients_resumes_to_the_same_bits) {
  TrainSettings settings;
  settings.sh_degree = 1;
  settings.strategy = "fastgs";
  settings.many_gaussians = true;
  settings.sum_gradients = true;
  const auto trainer_of = [&](int threads, int start) {
    ModelState model =
        ModelState::starting_with(test::perturbed(test::ball_of_gaussians(kGaussians, 1), 2));
    model.iteration = start;
    return test::trainer_on(Backend::cpu, settings, synthetic(), std::move(model), threads);
  };
  for (const auto& [start, end, pause] :
       {std::tuple{1090, 1106, 1099}, {1090, 1106, 1103}, {15'020, 15'045, 15'030}}) {
    Trainer whole = trainer_of(1, start);
    while (whole.iteration() < end) whole.step();
    Trainer first = trainer_of(2, start);
    while (first.iteration() < pause) first.step();
    EXPECT_EQ(first.model().summed.size(), first.gaussians());
    const TemporaryFolder folder;
    write_checkpoint({settings, "data", {}, first.model()}, folder / "checkpoint");
    Checkpoint read = read_checkpoint(folder / "checkpoint");
    expect_same(read.model, first.model());
    Trainer second =
        test::trainer_on(Backend::cpu, read.settings, synthetic(), std::move(read.model), 1);
    while (second.iteration() < end) second.step();
    expect_same(second.model(), whole.model());
  }
}

TEST(TrainFastgs, adds_gaussians_with_fewer_than_ten_training_views) {
  DataSet data = synthetic();
  TrainSettings settings = flat_colours();
  settings.strategy = "fastgs";
  settings.many_gaussians = true;
  for (const std::size_t views : {4u, 1u}) {
    data.training.resize(views);
    ModelState model =
        ModelState::starting_with(test::perturbed(test::ball_of_gaussians(kGaussians, 1), 2));
    model.iteration = kStart;
    Trainer trainer = test::trainer_on(Backend::cpu, settings, data, std::move(model));
    while (trainer.iteration() < 1001) trainer.step();
    EXPECT_GT(trainer.gaussians(), kGaussians) << views;
  }
}

INSTANTIATE_TEST_SUITE_P(TrainFit, TrainStrategy,
                         testing::Values("adc", "mcmc", "dash", "fastgs", "mask"),
                         [](const auto& row) { return std::string(row.param); });

}  // namespace
}  // namespace qs::train
