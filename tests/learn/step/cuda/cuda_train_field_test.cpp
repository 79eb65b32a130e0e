// SPDX-License-Identifier: MIT
// Colour fields and codes of shapes in training on the GPU, compared with the CPU's.
#include <algorithm>
#include <cmath>

#include "learn/run/field_model.h"
#include "learn/step/cpu/cpu_model.h"
#include "learn/step/cpu/field_pass.h"
#include "learn/step/cpu/passes.h"
#include "learn/step/cuda/gpu_model.h"
#include "learn/step/shape_codes.h"
#include "support/golden_field.h"
#include "support/gpu.h"
#include "support/scenes.h"
#include "support/train_scenes.h"

namespace qs::cuda::train {
namespace {

using qs::train::FieldState;
using qs::train::ModelState;
using test::groups_of;
using test::kHeight;
using test::kWidth;
using test::settings_of;
using test::small_scene;
using Scene = cpu::train::Parameters<float>;

class CudaTrainField : public test::GpuTest {};

ModelState state_of(const Scene& scene, const ColorField& field) {
  ModelState state = ModelState::starting_with(scene);
  state.color_field = FieldState::starting_with(field);
  return state;
}

struct Passes {
  std::vector<glm::vec3> color;
  std::vector<std::vector<float>> groups;
  FieldGradientCopies field;
};

/// Draws a view and differentiates it.
void run(GpuModel& model, const char* mode) {
  model.forward(test::front_camera(kWidth, kHeight), settings_of(find_culler(mode), false));
  model.set_pixel_gradients(test::pixel_weights<float>());
  model.backward({});
}

Passes on_gpu(const ModelState& state, const char* mode = "quadbox") {
  GpuModel model;
  model.set_state(state);
  run(model, mode);
  return {model.pixels().color, groups_of(model.gradients().by), model.field_gradients()};
}

Passes on_cpu(const ModelState& state) {
  const Camera camera = test::front_camera(kWidth, kHeight);
  const RenderSettings settings = settings_of(find_culler("quadbox"), false);
  const cpu::train::StepView view{camera, settings, test::pool()};
  const ColorField& field = state.color_field.field;
  const FieldGradient<float> gradient(field.grid, field.width, field.grid_values, field.weights);
  cpu::train::ForwardFrame<float> frame;
  cpu::train::BackwardScratch<float> scratch;
  cpu::train::Gradients<float> gradients;
  cpu::train::forward(view, state.parameters, frame, &gradient);
  cpu::train::backward<float>(view, state.parameters, frame, test::pixel_weights<float>(), scratch,
                              gradients, {}, &gradient);
  Passes passes{frame.color, groups_of(gradients.by), {}};
  for (std::size_t i = 0; i < gradients.by_field.grid.size(); ++i)
    passes.field.grid.push_back(gradients.by_field.grid.sum(i));
  passes.field.weights = gradients.by_field.weights;
  return passes;
}

/// Expects that all values agree up to `share` of the largest expected one.
template <class Values>
void expect_close(const Values& values, const Values& expected, double share = 1e-4) {
  ASSERT_EQ(values.size(), expected.size());
  double scale = 0;
  for (const auto value : expected) scale = std::max(scale, std::abs(static_cast<double>(value)));
  for (std::size_t i = 0; i < values.size(); ++i)
    ASSERT_NEAR(values[i], expected[i], share * scale) << "value " << i;
}

void expect_close(const Passes& passes, const Passes& expected) {
  for (std::size_t i = 0; i < expected.color.size(); ++i) {
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(passes.color[i][c], expected.color[i][c], 5e-5);
  }
  for (std::size_t group = 0; group < expected.groups.size(); ++group) {
    SCOPED_TRACE(testing::Message() << "group " << group);
    expect_close(passes.groups[group], expected.groups[group]);
  }
  expect_close(passes.field.grid, expected.field.grid);
  expect_close(passes.field.weights, expected.field.weights);
}

template <class Values>
std::size_t count_moved(const Values& values) {
  return static_cast<std::size_t>(
      std::count_if(values.begin(), values.end(), [](const auto value) { return value != 0; }));
}

/// A network of the published size, with smaller levels.
ColorField small_grid_field() { return test::golden_field({16, 9, 16, 1.447f}, 64); }

void expect_gradients_of_the_cpu(std::size_t count, const ColorField& field) {
  SCOPED_TRACE(testing::Message() << count << " Gaussians, width " << field.width);
  const ModelState state = state_of(test::with_masks(small_scene<float>(count, 5)), field);
  const Passes expected = on_cpu(state);
  EXPECT_GT(count_moved(expected.field.grid), 8u);
  EXPECT_GT(count_moved(expected.field.weights), field.weights.size() / 8);
  expect_close(on_gpu(state), expected);
}

TEST_F(CudaTrainField, colours_and_gradients_equal_those_of_the_cpu) {
  for (const std::size_t count : {1u, 63u, 300u}) {
    expect_gradients_of_the_cpu(count, test::tiny_field());
    expect_gradients_of_the_cpu(count, small_grid_field());
  }
  expect_gradients_of_the_cpu(100, test::published_field());
}

// A network's width and inputs in between.
TEST_F(CudaTrainField, networks_of_every_size_are_trained) {
  for (const auto& [levels, width] : {std::pair{1, 32}, {3, 48}, {12, 16}, {27, 64}}) {
    SCOPED_TRACE(testing::Message() << levels << " levels, width " << width);
    const ColorField field = test::golden_field({levels, 6, 3, 1.2f}, width);
    const ModelState state = state_of(small_scene<float>(70, 6), field);
    expect_close(on_gpu(state), on_cpu(state));
  }
}

// Lists of more than a tile, so that a block adds up several tiles.
TEST_F(CudaTrainField, long_lists_give_the_gradients_of_the_cpu) {
  constexpr std::size_t kCount = (kFieldBlocks * 5 / 2) * kFieldRun + 7;
  Scene scene = small_scene<float>(kCount, 8);
  for (std::size_t i = 0; i < kCount; ++i) {
    scene.log_scales[i] -= glm::vec3(3);
    scene.opacity_logits[i] = -2;
  }
  const ModelState state = state_of(scene, test::tiny_field());
  expect_close(on_gpu(state), on_cpu(state));
}

TEST_F(CudaTrainField, a_view_that_shows_nothing_has_no_gradients) {
  Scene scene = small_scene<float>(40, 15);
  for (glm::vec3& mean : scene.means) mean.z = -mean.z;
  const ModelState state = state_of(scene, test::tiny_field());
  GpuModel model;
  model.set_state(state);
  run(model, "quadbox");
  const FieldGradientCopies copies = model.field_gradients();
  EXPECT_EQ(copies.grid, std::vector<double>(state.color_field.field.grid_values.size()));
  EXPECT_EQ(copies.weights, std::vector<float>(state.color_field.field.weights.size()));
  qs::train::StepOrder order;
  order.field_rate = 0.01;
  model.step(order);
  EXPECT_EQ(model.state().color_field.field.grid_values, state.color_field.field.grid_values);
  EXPECT_EQ(model.state().color_field.field.weights, state.color_field.field.weights);
  EXPECT_EQ(model.state().color_field.steps, 1u);
}

TEST_F(CudaTrainField, lossless_modes_and_two_runs_give_the_same_bits) {
  const ModelState state = state_of(small_scene<float>(400, 7), small_grid_field());
  const Passes expected = on_gpu(state, "adr");
  for (const char* mode : {"adr", "quadbox", "exact"}) {
    SCOPED_TRACE(mode);
    const Passes passes = on_gpu(state, mode);
    EXPECT_EQ(passes.color, expected.color);
    EXPECT_EQ(passes.groups, expected.groups);
    EXPECT_EQ(passes.field.grid, expected.field.grid);
    EXPECT_EQ(passes.field.weights, expected.field.weights);
  }
}

TEST_F(CudaTrainField, the_field_takes_the_steps_of_the_cpu_bit_for_bit) {
  const ModelState state = state_of(small_scene<float>(200, 3), test::tiny_field());
  FieldState expected = state.color_field;
  GpuModel model;
  model.set_state(state);
  for (int step = 0; step < 4; ++step) {
    run(model, "quadbox");
    if (step == 2) run(model, "exact");  // replaces the gradients
    const FieldGradientCopies by = model.field_gradients();
    cpu::train::FieldGradients<float> gradients;
    gradients.grid.reset(by.grid.size());
    for (std::size_t i = 0; i < by.grid.size(); ++i) gradients.grid.add(i, by.grid[i]);
    gradients.weights = by.weights;
    const double rate = 1e-3 * (step + 1);
    cpu::train::take_field_step(gradients, rate, expected, test::pool());
    qs::train::StepOrder order = test::counted_step({});
    order.field_rate = rate;
    order.moves = step != 1;  // the field takes a step in every iteration
    model.step(order);
    const FieldState& result = model.state().color_field;
    EXPECT_EQ(result.field.grid_values, expected.field.grid_values);
    EXPECT_EQ(result.field.weights, expected.field.weights);
    EXPECT_EQ(result.first, expected.first);
    EXPECT_EQ(result.second, expected.second);
    EXPECT_EQ(result.steps, expected.steps);
  }
  EXPECT_NE(expected.field.grid_values, state.color_field.field.grid_values);
  EXPECT_NE(expected.field.weights, state.color_field.field.weights);
}

TEST_F(CudaTrainField, steps_lower_the_loss_as_on_the_cpu) {
  const ModelState state = state_of(small_scene<float>(60, 12), test::tiny_field());
  GpuModel gpu;
  cpu::train::CpuModel cpu(test::pool());
  std::vector<std::uint8_t> rgb(3 * kWidth * kHeight);
  for (std::size_t i = 0; i < rgb.size(); ++i)
    rgb[i] = static_cast<std::uint8_t>(i / 3 % std::size_t{kWidth} * 5);
  const auto losses = [&](qs::train::TrainingModel& model) {
    model.set_state(state);
    std::vector<double> result;
    for (int step = 0; step < 9; ++step) {
      model.forward(test::front_camera(kWidth, kHeight), settings_of(default_mode(), false));
      model.compare_with(0, {rgb, {}, {}});
      model.backward({});
      qs::train::StepOrder order;
      order.rates = {1e-3, 2e-3, 3e-3, 4e-3, 0, 0, 0};
      order.field_rate = 5e-3;
      model.step(order);
      result.push_back(model.recent_loss().total);
    }
    return result;
  };
  const std::vector<double> on_gpu = losses(gpu), on_cpu = losses(cpu);
  // The GPU's loss is known one comparison later.
  for (std::size_t step = 1; step + 1 < on_cpu.size(); ++step)
    EXPECT_NEAR(on_gpu[step + 1], on_cpu[step], 1e-3 * on_cpu[step]) << step;
  EXPECT_LT(on_gpu.back(), 0.95 * on_gpu[1]);
}

TEST_F(CudaTrainField, gradients_that_are_not_finite_never_get_into_the_field) {
  GpuModel model;
  model.set_state(state_of(small_scene<float>(50, 5), test::tiny_field()));
  for (const float bad : {NAN, INFINITY, -INFINITY, 3e38f}) {
    model.forward(test::front_camera(kWidth, kHeight), settings_of(default_mode(), false));
    model.set_pixel_gradients(
        std::vector<glm::vec3>(static_cast<std::size_t>(kWidth * kHeight), glm::vec3(bad)));
    model.backward({});
    qs::train::StepOrder order = test::counted_step({});
    order.field_rate = 0.01;
    model.step(order);
  }
  const FieldState& field = model.state().color_field;
  for (const float value : field.field.grid_values) ASSERT_TRUE(std::isfinite(value));
  for (const float value : field.field.weights) ASSERT_TRUE(std::isfinite(value));
}

TEST_F(CudaTrainField, a_model_without_field_forgets_the_field_before) {
  const Scene scene = small_scene<float>(60, 9);
  GpuModel used, fresh;
  used.set_state(state_of(scene, test::tiny_field()));
  run(used, "quadbox");
  test::start(used, scene);
  test::start(fresh, scene);
  run(used, "quadbox");
  run(fresh, "quadbox");
  EXPECT_EQ(used.pixels().color, fresh.pixels().color);
  EXPECT_EQ(groups_of(used.gradients().by), groups_of(fresh.gradients().by));
  EXPECT_FALSE(used.state().color_field.exists());
}

class CudaTrainCodes : public test::GpuTest {
 protected:
  static ModelState coded_state(std::size_t count) {
    ModelState state = state_of(test::with_masks(small_scene<float>(count, 5)), test::tiny_field());
    state.codes = qs::train::first_codes(state, 1, test::pool());
    return state;
  }
};

TEST_F(CudaTrainCodes, codes_take_the_steps_of_the_cpu_bit_for_bit) {
  for (const std::size_t count : {1u, 300u}) {
    const ModelState state = coded_state(count);
    GpuModel model;
    model.set_state(state);
    qs::train::ShapeCodes expected = state.codes;
    for (int step = 0; step < 3; ++step) {
      run(model, "quadbox");
      model.step(test::counted_step({1e-2, 1e-2, 1e-2, 1e-2, 0, 0, 1e-2}));
      const qs::train::Parameters& moved = model.parameters();
      take_code_step(expected.scales, qs::train::scale_vectors(moved), test::pool());
      take_code_step(expected.rotations, qs::train::rotation_vectors(moved), test::pool());
      const qs::train::ShapeCodes& codes = model.state().codes;
      EXPECT_EQ(codes.scales.codebook.values, expected.scales.codebook.values);
      EXPECT_EQ(codes.scales.first, expected.scales.first);
      EXPECT_EQ(codes.scales.second, expected.scales.second);
      EXPECT_EQ(codes.rotations.codebook.values, expected.rotations.codebook.values);
      EXPECT_EQ(codes.rotations.second, expected.rotations.second);
      EXPECT_EQ(codes.scales.steps, expected.scales.steps);
    }
    EXPECT_NE(expected.scales.codebook.values, state.codes.scales.codebook.values);
    EXPECT_NE(expected.rotations.codebook.values, state.codes.rotations.codebook.values);
  }
}

// The coded model equals a model whose shapes are the codes; only the derivatives by shapes differ.
TEST_F(CudaTrainCodes, passes_draw_the_coded_shapes_and_pass_their_gradient_on) {
  const ModelState state = coded_state(200);
  ModelState drawn = state;
  drawn.codes = {};
  code_shapes(state.parameters, state.codes, test::pool(), drawn.parameters);
  GpuModel coded, plain;
  coded.set_state(state);
  plain.set_state(drawn);
  run(coded, "quadbox");
  run(plain, "quadbox");
  EXPECT_EQ(coded.pixels().color, plain.pixels().color);
  qs::train::Parameters by = plain.gradients().by;
  EXPECT_NE(coded.gradients().by.log_scales, by.log_scales);
  pass_through_codes(state.parameters, drawn.parameters, test::pool(), by);
  const auto groups = groups_of(coded.gradients().by), expected = groups_of(by);
  for (std::size_t group = 0; group < expected.size(); ++group)
    expect_close(groups[group], expected[group], 1e-6);
}

TEST_F(CudaTrainCodes, are_read_back_as_they_were) {
  const ModelState state = coded_state(20);
  GpuModel model;
  model.set_state(state);
  const qs::train::ShapeCodes& codes = model.state().codes;
  EXPECT_EQ(codes.scales.codebook.values, state.codes.scales.codebook.values);
  EXPECT_EQ(codes.rotations.codebook.values, state.codes.rotations.codebook.values);
  EXPECT_EQ(codes.rotations.codebook.dimensions, 4u);
  model.set_state(state_of(state.parameters, test::tiny_field()));
  EXPECT_FALSE(model.state().codes.exist());
}

}  // namespace
}  // namespace qs::cuda::train
