// SPDX-License-Identifier: MIT
// Training on the GPU by the same trainer as on the CPU.
#include <chrono>
#include <numeric>

#include <gmock/gmock.h>

#include "app/support/training.h"
#include "learn/run/field_model.h"
#include "learn/run/initial.h"
#include "learn/run/model_folder.h"
#include "learn/run/strategy.h"
#include "support/error_of.h"
#include "support/golden_field.h"
#include "support/gpu.h"
#include "support/temporary_folder.h"

namespace qs::train {
namespace {

using test::expect_same;

constexpr std::size_t kGaussians = 60;

const DataSet& synthetic() {
  static const DataSet data = test::data_set_of(test::ball_of_gaussians(kGaussians, 1), 8);
  return data;
}

/// The state of a run whose iteration `last` is over.
ModelState perturbed_state(int last = 0) {
  ModelState state =
      ModelState::starting_with(test::perturbed(test::ball_of_gaussians(kGaussians, 1), 2));
  state.iteration = last;
  return state;
}

Trainer trainer_on(Backend backend, const TrainSettings& settings, ModelState state) {
  return test::trainer_on(backend, settings, synthetic(), std::move(state));
}

void train_until(Trainer& trainer, int iteration) {
  while (trainer.iteration() < iteration) trainer.step();
}

TrainSettings settings_of(const std::string& strategy) {
  TrainSettings settings;
  settings.sh_degree = 0;
  settings.strategy = strategy;
  settings.max_gaussians = 80;
  settings.many_gaussians = true;  // read by fastgs
  return settings;
}

class CudaTrainFit : public test::GpuTest, public testing::WithParamInterface<const char*> {};

// Beyond iteration 1,000, after which all strategies add and remove Gaussians.
constexpr int kStart = 990, kBreak = 1001, kEnd = 1005;

TEST_P(CudaTrainFit, test_views_get_as_good_as_on_the_cpu) {
  if (std::string(GetParam()) != "mcmc") {
    QS_EMULATED_BEFORE_A_RELEASE();
  }
  const TrainSettings settings = settings_of(GetParam());
  Trainer gpu = trainer_on(Backend::cuda, settings, perturbed_state());
  Trainer cpu = trainer_on(Backend::cpu, settings, perturbed_state());
  const double before = gpu.test_quality()->psnr;
  EXPECT_NEAR(before, cpu.test_quality()->psnr, 0.001);
  train_until(gpu, 150);
  train_until(cpu, 150);
  const double after = gpu.test_quality()->psnr;
  EXPECT_GT(after, before + 4);
  EXPECT_NEAR(after, cpu.test_quality()->psnr, 0.1);
}

TEST_P(CudaTrainFit, a_resumed_run_and_another_run_give_the_same_bits) {
  const TrainSettings settings = settings_of(GetParam());
  Trainer whole = trainer_on(Backend::cuda, settings, perturbed_state(kStart));
  train_until(whole, kEnd);
  EXPECT_NE(whole.gaussians(), kGaussians) << "the set of Gaussians changed";

  Trainer first = trainer_on(Backend::cuda, settings, perturbed_state(kStart));
  train_until(first, kBreak);
  const TemporaryFolder folder;
  write_checkpoint({settings, "data", {}, first.model()}, folder / "checkpoint");
  Checkpoint read = read_checkpoint(folder / "checkpoint");
  Trainer second = trainer_on(Backend::cuda, settings, std::move(read.model));
  train_until(second, kEnd);
  expect_same(second.model(), whole.model());
}

TEST_P(CudaTrainFit, each_backend_continues_the_others_run) {
  const TrainSettings settings = settings_of(GetParam());
  for (const auto& [from, to] :
       {std::pair{Backend::cuda, Backend::cpu}, {Backend::cpu, Backend::cuda}}) {
    Trainer first = trainer_on(from, settings, perturbed_state(kStart));
    train_until(first, kBreak);
    Trainer second = trainer_on(to, settings, first.model());
    expect_same(second.model(), first.model());
    train_until(second, kEnd);
    train_until(first, kEnd);
    EXPECT_EQ(second.gaussians(), first.gaussians());
    EXPECT_NEAR(second.test_quality()->psnr, first.test_quality()->psnr, 0.05);
  }
}

TEST_P(CudaTrainFit, the_plan_of_a_strategy_makes_the_state_that_it_makes_on_the_cpu) {
  const Strategy& strategy = find_strategy(GetParam());
  const TrainSettings settings = settings_of(GetParam());
  ModelState state = perturbed_state(3000);
  if (strategy.has_masks) {
    state = ModelState::starting_with(with_masks(state.parameters));
    state.iteration = 3000;
    for (std::size_t i = 0; i < kGaussians; ++i) {
      state.parameters.mask_logits[i] = i % 9 == 5 ? -5.0f : static_cast<float>(i);
      state.adam.second.mask_logits[i] = static_cast<float>(i);
    }
  }
  for (std::size_t i = 0; i < kGaussians; ++i) {
    state.density.sums[i] = i % 4 == 0 ? 1e-2f : 1e-4f;
    state.density.views[i] = 2;
    state.adam.first.means[i] = state.adam.second.sh[i] = glm::vec3(static_cast<float>(i));
    state.adam.second.opacity_logits[i] = 5;
  }
  state.parameters.opacity_logits[7] = -6;  // nearly transparent
  const auto model = make_training_model(Backend::cuda, test::pool());
  model->set_state(state);
  expect_same(model->state(), state);
  ASSERT_TRUE(strategy.changes_before(settings, 3001));
  Plan plan;
  strategy.plan({settings, 3001, 5, {}}, model->facts(), plan);
  model->apply(plan);
  const ModelState expected = changed(state, plan);
  EXPECT_NE(expected.size(), kGaussians);
  expect_same(model->state(), expected);
}

INSTANTIATE_TEST_SUITE_P(CudaTrain, CudaTrainFit,
                         testing::Values("adc", "mcmc", "dash", "fastgs", "mask"),
                         [](const auto& row) { return std::string(row.param); });

class CudaTrainPaced : public test::GpuTest {};

// Through the first change, a decay that clears all moments, and a measurement of the guard.
TEST_F(CudaTrainPaced, a_resumed_run_and_another_run_give_the_same_bits) {
  TrainSettings settings = settings_of("paced");
  settings.iterations = 400;
  settings.guard = true;
  settings.max_gaussians = 75;
  const auto trained = [&](std::initializer_list<int> parts) {
    ModelState state = perturbed_state(115);
    std::vector<GuardRow> measured;
    for (const int until : parts) {
      auto model = make_training_model(Backend::cuda, test::pool());
      model->set_state(std::move(state));
      Trainer trainer(settings, synthetic(), std::move(model), test::pool(), measured);
      train_until(trainer, until);
      state = trainer.model();
      measured = trainer.guard().rows();
    }
    EXPECT_EQ(measured.size(), 1u);
    return state;
  };
  const ModelState whole = trained({124});
  EXPECT_EQ(whole.size(), 65u) << "5/13 of the way";
  expect_same(trained({119, 120, 121, 124}), whole);
}

class CudaTrainFieldRun : public test::GpuTest {
 protected:
  static TrainSettings field_settings() {
    TrainSettings settings = settings_of("mask");
    settings.color_field = true;
    return settings;
  }
  static ModelState field_state(int last = 0) {
    ModelState state = ModelState::starting_with(with_masks(perturbed_state().parameters));
    state.iteration = last;
    state.color_field = starting_field(3, test::kTinyGrid, 16);
    return state;
  }
};

TEST_F(CudaTrainFieldRun, test_views_get_as_good_as_on_the_cpu) {
  QS_EMULATED_BEFORE_A_RELEASE();
  Trainer gpu = trainer_on(Backend::cuda, field_settings(), field_state());
  Trainer cpu = trainer_on(Backend::cpu, field_settings(), field_state());
  const double before = gpu.test_quality()->psnr;
  EXPECT_NEAR(before, cpu.test_quality()->psnr, 0.001);
  train_until(gpu, 100);
  train_until(cpu, 100);
  EXPECT_GT(gpu.test_quality()->psnr, before + 1);
  EXPECT_NEAR(gpu.test_quality()->psnr, cpu.test_quality()->psnr, 0.2);
}

// The set of Gaussians changes before iteration 1,001, and codes are drawn before iteration 29,001.
TEST_F(CudaTrainFieldRun, a_resumed_run_and_lossless_modes_give_the_same_bits) {
  for (const auto& [first_iteration, last] : {std::pair{990, 1005}, {28'998, 29'006}}) {
    Trainer whole = trainer_on(Backend::cuda, field_settings(), field_state(first_iteration));
    train_until(whole, last);
    EXPECT_EQ(whole.model().color_field.steps, static_cast<std::uint64_t>(last - first_iteration));
    EXPECT_EQ(whole.model().codes.exist(), last > kCodesAfter);
    EXPECT_EQ(whole.model().codes.scales.steps, last > kCodesAfter ? 6u : 0u);

    Trainer first = trainer_on(Backend::cuda, field_settings(), field_state(first_iteration));
    train_until(first, last - 4);
    const TemporaryFolder folder;
    write_checkpoint({field_settings(), "data", {}, first.model()}, folder / "checkpoint");
    Checkpoint read = read_checkpoint(folder / "checkpoint");
    expect_same(read.model, first.model());
    TrainSettings exact = field_settings();
    exact.mode = find_culler("exact");
    Trainer second = trainer_on(Backend::cuda, exact, std::move(read.model));
    train_until(second, last);
    expect_same(second.model(), whole.model());
  }
}

TEST_F(CudaTrainFieldRun, each_backend_continues_the_others_run) {
  for (const auto& [from, to] :
       {std::pair{Backend::cuda, Backend::cpu}, {Backend::cpu, Backend::cuda}}) {
    for (const int begin : {995, 28'998}) {
      Trainer first = trainer_on(from, field_settings(), field_state(begin));
      train_until(first, begin + 6);
      Trainer second = trainer_on(to, field_settings(), first.model());
      expect_same(second.model(), first.model());
      train_until(second, begin + 10);
      train_until(first, begin + 10);
      EXPECT_EQ(second.gaussians(), first.gaussians());
      EXPECT_NEAR(second.test_quality()->psnr, first.test_quality()->psnr, 0.05);
    }
  }
}

TEST_F(CudaTrainFieldRun, a_network_that_is_too_large_is_refused_in_a_sentence) {
  ModelState state = perturbed_state();
  state.color_field = starting_field(1, test::kTinyGrid, 80);
  const auto model = make_training_model(Backend::cuda, test::pool());
  EXPECT_THAT(test::error_of([&] { model->set_state(state); }, ErrorKind::device),
              testing::HasSubstr("a width of 80, at most 64"));
}

class CudaTrainClock : public test::GpuTest {};

TEST_F(CudaTrainClock, the_stages_of_a_step_add_up_to_its_time) {
  Trainer trainer = trainer_on(Backend::cuda, settings_of("adc"), perturbed_state());
  for (int i = 0; i < 4; ++i) {
    if (i == 2) trainer.test_quality();  // draws views without the other passes
    const auto begin = std::chrono::steady_clock::now();
    const StepResult step = trainer.step();
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
    const double sum = std::accumulate(step.seconds.begin(), step.seconds.end(), 0.0);
    EXPECT_GT(sum, 0);
    EXPECT_LE(sum, time.count());
    for (std::size_t pass = 1; pass <= 4; ++pass) EXPECT_GT(step.seconds[pass], 0) << pass;
  }
}

class CudaTrainPhotographs : public test::GpuTest {};

TEST_F(CudaTrainPhotographs, ones_that_do_not_fit_into_photo_memory_give_the_same_bits) {
  const TemporaryFolder folder;
  test::write_data_set(synthetic(), folder.path());
  const auto read = [&](std::uint64_t photographs) {
    DataOptions options;
    options.data = folder.path();
    options.holdout = 4;
    options.photo_memory = photographs * 64 * 48 * 3;
    return read_data_set(options, test::pool());
  };
  const DataSet all = read(8), two = read(2);
  ASSERT_FALSE(all.on_disk());
  ASSERT_TRUE(two.on_disk());
  Trainer kept = test::trainer_on(Backend::cuda, settings_of("adc"), all, perturbed_state());
  Trainer streamed = test::trainer_on(Backend::cuda, settings_of("adc"), two, perturbed_state());
  for (int i = 0; i < 15; ++i) EXPECT_EQ(kept.step().loss.total, streamed.step().loss.total);
  EXPECT_EQ(kept.test_quality()->psnr, streamed.test_quality()->psnr);
  expect_same(kept.model(), streamed.model());
}

class CudaTrainCloud : public test::GpuTest {};

TEST_F(CudaTrainCloud, the_windows_copy_holds_the_gaussians_of_the_last_step) {
  Trainer trainer = trainer_on(Backend::cuda, settings_of("adc"), perturbed_state());
  const GaussianCloud first = trainer.cloud();
  train_until(trainer, 3);
  const GaussianCloud third = trainer.cloud();
  const auto positions = [](const GaussianCloud& cloud) {
    return std::vector(cloud.positions.begin(), cloud.positions.end());
  };
  EXPECT_EQ(positions(first), perturbed_state().parameters.means);
  EXPECT_NE(positions(third), positions(first));
  EXPECT_EQ(positions(third), trainer.model().parameters.means);
}

class CudaTrainPlan : public test::GpuTest {};

TEST_F(CudaTrainPlan, a_set_may_become_empty_and_training_ends_with_a_sentence) {
  ModelState state = perturbed_state(600);
  for (float& logit : state.parameters.opacity_logits) logit = -9;
  Trainer trainer = trainer_on(Backend::cuda, settings_of("adc"), state);
  EXPECT_THAT(test::error_of([&] { trainer.step(); }, ErrorKind::input),
              testing::HasSubstr("no Gaussian is left in iteration 601"));
}

}  // namespace
}  // namespace qs::train
