// SPDX-License-Identifier: MIT
// Training of models whose colours a colour field computes.
// Not in checked: whole trainings take long there; field_gradient_test.cpp runs the same code.
#include "learn/run/field_model.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>

#include "app/support/training.h"
#include "io/scene/reader.h"
#include "learn/run/initial.h"
#include "learn/run/model_folder.h"
#include "learn/run/trainer.h"
#include "learn/step/shape_codes.h"
#include "raster/kernel/activation.h"
#include "support/error_of.h"
#include "support/golden_field.h"
#include "support/pool.h"
#include "support/temporary_folder.h"

namespace qs::train {
namespace {

using test::expect_same;

constexpr std::size_t kFieldGaussians = 120;

const DataSet& pictures() {
  static const DataSet data = test::data_set_of(test::ball_of_gaussians(kFieldGaussians, 1), 12);
  return data;
}

TrainSettings field_settings() {
  TrainSettings settings;
  settings.sh_degree = 0;
  settings.strategy = "mask";
  settings.color_field = true;
  settings.seed = 3;
  return settings;
}

Trainer field_trainer(const TrainSettings& settings, int threads, int last = 0) {
  ModelState model = ModelState::starting_with(
      with_masks(test::perturbed(test::ball_of_gaussians(kFieldGaussians, 1), 2)));
  model.iteration = last;
  model.color_field = starting_field(settings.seed, test::kTinyGrid, 16);
  return test::trainer_on(Backend::cpu, settings, pictures(), std::move(model), threads);
}

TEST(TrainField, begins_with_small_values_of_the_grid_and_weights_of_the_published_size) {
  const FieldState state = starting_field(7, test::kTinyGrid, 16);
  ASSERT_EQ(state.field.grid_values.size(), 448u);
  ASSERT_EQ(state.field.weights.size(), 1024u);
  EXPECT_EQ(state.first, std::vector<float>(448 + 1024, 0.0f));
  EXPECT_EQ(state.second, state.first);
  const auto largest = [](const std::vector<float>& values, std::size_t begin, std::size_t end) {
    float most = 0;
    for (std::size_t i = begin; i < end; ++i) most = std::max(most, std::abs(values[i]));
    return most;
  };
  EXPECT_LE(largest(state.field.grid_values, 0, 448), 1e-4f);
  EXPECT_GT(largest(state.field.grid_values, 0, 448), 0.95e-4f);
  const float bound = std::sqrt(6.0f / 48);  // of the matrix of 16 x 32
  EXPECT_LE(largest(state.field.weights, 0, 512), bound);
  EXPECT_GT(largest(state.field.weights, 0, 512), 0.95f * bound);
  EXPECT_LE(largest(state.field.weights, 512, 1024), std::sqrt(6.0f / 32));
  EXPECT_NE(starting_field(8, test::kTinyGrid, 16).field.weights, state.field.weights);
  EXPECT_FALSE(ModelState().color_field.exists());
}

TEST(TrainField, the_rate_rises_for_100_iterations_and_falls_three_times) {
  for (const auto& [iteration, rate] : {std::pair{1, 1e-4},
                                        {51, 5.05e-3},
                                        {101, 0.01},
                                        {5000, 0.01},
                                        {5001, 0.0033},
                                        {15'001, 0.001089},
                                        {25'001, 3.5937e-4},
                                        {30'000, 3.5937e-4}})
    EXPECT_NEAR(field_rate_at(iteration), rate, 1e-12) << iteration;
}

TEST(TrainField, colours_are_learned) {
  Trainer trainer = field_trainer(field_settings(), 0);
  const double before = trainer.test_quality()->psnr;
  while (trainer.iteration() < 250) trainer.step();
  EXPECT_GT(trainer.test_quality()->psnr, before + 4);
}

// The set of Gaussians changes before iteration 601; the field takes a step in iteration 600 too.
TEST(TrainField, a_resumed_run_other_threads_and_lossless_modes_give_the_same_bits) {
  constexpr int kFirst = 590, kBreak = 600, kEnd = 604;
  Trainer whole = field_trainer(field_settings(), 1, kFirst);
  while (whole.iteration() < kEnd) whole.step();
  EXPECT_EQ(whole.model().color_field.steps, std::uint64_t{kEnd - kFirst});
  EXPECT_LT(whole.model().adam.steps, std::uint64_t{kEnd - kFirst});

  Trainer first = field_trainer(field_settings(), 3, kFirst);
  while (first.iteration() < kBreak) first.step();
  const TemporaryFolder folder;
  write_checkpoint({field_settings(), "data", {}, first.model()}, folder / "checkpoint");
  Checkpoint read = read_checkpoint(folder / "checkpoint");
  expect_same(read.model, first.model());
  EXPECT_TRUE(read.settings.color_field);
  TrainSettings exact = field_settings();
  exact.mode = find_culler("exact");
  Trainer second = test::trainer_on(Backend::cpu, exact, pictures(), std::move(read.model), 2);
  while (second.iteration() < kEnd) second.step();
  expect_same(second.model(), whole.model());
}

TEST(TrainField, the_saved_model_is_opened_with_its_network_and_without_masked_out_gaussians) {
  ModelState model =
      ModelState::starting_with(with_masks(test::ball_of_gaussians(kFieldGaussians, 1)));
  model.iteration = 5;
  model.parameters.mask_logits[3] = -5;
  model.color_field = FieldState::starting_with(test::published_field());
  const TemporaryFolder folder;
  const auto file = write_gaussians(folder / "model", field_settings(), model, {}, test::pool());
  EXPECT_EQ(file.filename(), "point_cloud.ply");
  const Scene scene = read_scene(file, test::pool(), {});
  ASSERT_EQ(scene.cloud.size(), kFieldGaussians - 1);
  ASSERT_TRUE(scene.network);
  EXPECT_EQ(scene.network->field->weights, model.color_field.field.weights);
  EXPECT_EQ(scene.network->field->grid_values, model.color_field.field.grid_values);
  const GaussianCloud expected = fitted_cloud(model, false, test::pool());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(scene.cloud.positions[i], expected.positions[i]);
    EXPECT_NEAR(scene.cloud.opacity_logits[i], expected.opacity_logits[i], 1e-4);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(scene.cloud.sh[16 * i][axis], expected.sh[16 * i][axis], 1e-6);
  }
  const OldIterations old = remove_old_iterations(folder / "model");
  EXPECT_THAT(old.removed, testing::ElementsAre(5));
  EXPECT_FALSE(std::filesystem::exists(file.parent_path()));
}

// Codes are drawn before iteration 29,001. The run breaks while they are trained, and Gaussians
// that are masked out are removed before iteration 29,001 too.
TEST(TrainField, codes_of_shapes_are_trained_after_29000_and_resume_to_the_same_bits) {
  constexpr int kFirst = 28'998, kBreak = 29'002, kEnd = 29'006;
  Trainer whole = field_trainer(field_settings(), 1, kFirst);
  whole.step();
  EXPECT_FALSE(whole.model().codes.exist());
  while (whole.iteration() < kEnd) whole.step();
  EXPECT_EQ(whole.model().codes.scales.steps, 6u);
  EXPECT_EQ(whole.model().codes.rotations.steps, 6u);

  Trainer first = field_trainer(field_settings(), 3, kFirst);
  while (first.iteration() < kBreak) first.step();
  const TemporaryFolder folder;
  write_checkpoint({field_settings(), "data", {}, first.model()}, folder / "checkpoint");
  Checkpoint read = read_checkpoint(folder / "checkpoint");
  expect_same(read.model, first.model());
  Trainer second =
      test::trainer_on(Backend::cpu, field_settings(), pictures(), std::move(read.model), 2);
  while (second.iteration() < kEnd) second.step();
  expect_same(second.model(), whole.model());
}

TEST(TrainField, a_checkpoint_with_another_size_of_the_field_is_refused) {
  ModelState model = ModelState::starting_with(with_masks(test::ball_of_gaussians(3, 1)));
  model.color_field = starting_field(1, test::kTinyGrid, 16);
  const TemporaryFolder folder;
  const auto path = folder / "checkpoint";
  write_checkpoint({field_settings(), "data", {}, model}, path);
  std::ifstream file(path, std::ios::binary);
  const std::string whole(std::istreambuf_iterator<char>(file), {});
  for (const char* name : {"width", "levels"}) {
    std::string changed = whole;
    const std::size_t at = changed.find_first_of("0123456789", changed.find(name));
    changed[at] = '9';
    std::ofstream(path, std::ios::binary) << changed;
    EXPECT_THAT(test::error_of([&] { read_checkpoint(path); }, ErrorKind::input),
                testing::HasSubstr("damaged"))
        << name;
  }
}

TEST(TrainField, codes_stand_for_the_shapes_and_pass_their_gradient_on) {
  const Parameters gaussians = test::ball_of_gaussians(300, 1);
  const ModelState model = ModelState::starting_with(gaussians);
  const ShapeCodes codes = first_codes(model, 1, test::pool());
  Parameters drawn;
  code_shapes(gaussians, codes, test::pool(), drawn);
  Parameters by = gaussians;
  for (std::size_t i = 0; i < gaussians.size(); ++i) {
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(std::exp(drawn.log_scales[i][k]), std::exp(gaussians.log_scales[i][k]), 0.02);
    const float cosine = std::abs(
        glm::dot(glm::normalize(gaussians.rotations[i]), glm::normalize(drawn.rotations[i])));
    EXPECT_GT(cosine, 0.99f);
    by.log_scales[i] = glm::vec3(2);
    by.rotations[i] = glm::quat(1, 2, 3, 4);
  }
  pass_through_codes(gaussians, drawn, test::pool(), by);
  for (std::size_t i = 0; i < gaussians.size(); ++i) {
    // The derivative by a deviation stays: 2 = s dL/ds for the coded deviation s.
    EXPECT_NEAR(by.log_scales[i].x,
                2 / std::exp(drawn.log_scales[i].x) * std::exp(gaussians.log_scales[i].x), 1e-3);
    EXPECT_NEAR(glm::dot(by.rotations[i], gaussians.rotations[i]), 0, 1e-4)
        << "the length of a quaternion has no gradient";
  }
}

class TrainFieldForms : public testing::TestWithParam<bool> {};

TEST_P(TrainFieldForms, show_the_same_gaussians) {
  ModelState model =
      ModelState::starting_with(with_masks(test::ball_of_gaussians(kFieldGaussians, 1)));
  model.parameters.mask_logits[3] = -5;
  model.color_field = FieldState::starting_with(test::published_field());
  if (GetParam()) model.codes = first_codes(model, 1, test::pool());
  const TemporaryFolder folder;
  const auto ply = folder / "point_cloud.ply";
  write_field_model(model, ply, test::pool());
  write_coded_models(model, 1, ply, test::pool());
  const Scene expected = read_scene(ply, test::pool(), {});
  for (const char* name : {"point_cloud.npz", "point_cloud_pp.npz"}) {
    const Scene scene = read_scene(folder / name, test::pool(), {});
    ASSERT_EQ(scene.cloud.size(), kFieldGaussians - 1) << name;
    double squares = 0;
    for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
      EXPECT_LT(glm::distance(scene.cloud.positions[i], expected.cloud.positions[i]), 2e-3f);
      // Both may turn the axes differently, so the covariances are compared.
      const auto shape = [&](const GaussianCloud& cloud) {
        return covariance_of(glm::dvec3(cloud.log_scales[i]), glm::dquat(cloud.rotations[i]));
      };
      const auto a = shape(scene.cloud), b = shape(expected.cloud);
      const double size = b.xx + b.yy + b.zz;
      squares += (std::pow(a.xx - b.xx, 2) + std::pow(a.yy - b.yy, 2) + std::pow(a.zz - b.zz, 2) +
                  std::pow(a.xy - b.xy, 2)) /
                 (size * size);
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(scene.cloud.size())), 0.02) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(TrainField, TrainFieldForms, testing::Bool(), [](const auto& row) {
  return row.param ? "trained_codes" : "fitted_codes";
});

TEST(TrainField, forms_without_gaussians_are_written) {
  ModelState model = ModelState::starting_with(with_masks(test::ball_of_gaussians(1, 1)));
  model.parameters.mask_logits[0] = -5;
  model.color_field = starting_field(1);
  const TemporaryFolder folder;
  write_field_model(model, folder / "point_cloud.ply", test::pool());
  write_coded_models(model, 1, folder / "point_cloud.ply", test::pool());
  EXPECT_TRUE(std::filesystem::exists(folder / "point_cloud_pp.npz"));
}

TEST(TrainField, a_model_without_gaussians_in_view_trains_on) {
  ModelState model = ModelState::starting_with(with_masks(test::ball_of_gaussians(1, 1)));
  model.parameters.mask_logits[0] = -5;
  model.color_field = starting_field(1, test::kTinyGrid, 16);
  Trainer trainer =
      test::trainer_on(Backend::cpu, field_settings(), pictures(), std::move(model), 1);
  trainer.step();
  EXPECT_EQ(trainer.model().color_field.steps, 1u);
}

}  // namespace
}  // namespace qs::train
