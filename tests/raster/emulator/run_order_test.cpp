// SPDX-License-Identifier: MIT
// The order in which a GPU runs blocks and threads changes no bit of a picture or of a gradient.
#include <algorithm>
#include <random>

#include "cuda_runtime.h"
#include "learn/run/field_model.h"
#include "learn/step/cuda/gpu_model.h"
#include "support/golden_field.h"
#include "support/gpu.h"
#include "support/scenes.h"
#include "support/train_scenes.h"

namespace qs {
namespace {

class RunOrder : public testing::Test {
 protected:
  void TearDown() override { emulator::run_order = 0; }

  static constexpr unsigned kOrders = 4;
};

/// Scattered Gaussians of many colours and opacities; every two have the same depth.
GaussianCloud colorful_cloud(std::size_t count, int side) {
  GaussianCloud cloud = test::scattered_cloud(
      count, side, [](std::size_t i) { return 2 + 1e-4 * double(i / 2 * 7919 % 9973); });
  std::mt19937 random(5);
  std::uniform_real_distribution<float> opacity(-6, -1), color(-1.7f, 1.7f);
  for (std::size_t i = 0; i < count; ++i) {
    cloud.opacity_logits[i] = opacity(random);
    cloud.sh[i] = glm::vec3(color(random), color(random), color(random));
  }
  return cloud;
}

// Usual macro-tiles, full macro-tiles, macro-tiles that are cut into slices, and lists that are cut
// by depth.
TEST_F(RunOrder, changes_no_picture) {
  for (const std::size_t count : {800u, 3400u, 30'000u}) {
    for (const Pipeline pipeline : {Pipeline::classic, Pipeline::fast}) {
      SCOPED_TRACE(testing::Message() << count << " " << kPipelineNames[int(pipeline)]);
      RenderSettings settings;
      settings.pipeline = pipeline;
      std::vector<float> expected;
      for (unsigned order = 0; order <= kOrders; ++order) {
        emulator::run_order = order;
        const auto renderer = make_renderer(Backend::cuda, test::pool());
        renderer->upload(colorful_cloud(count, 32), {});
        std::vector<float> values;
        std::uint32_t longest = 0;
        for (const int side : {32, 24}) {  // the buffers have grown before the second frame
          const Frame& frame = renderer->render(test::front_camera(side, side), settings);
          values.insert(values.end(), frame.color.values.begin(), frame.color.values.end());
          longest = std::max(longest, frame.stats.max_pairs_in_a_tile);
        }
        if (order == 0) expected = values;
        EXPECT_EQ(values, expected) << order;
        EXPECT_GT(longest, count / 8);
      }
    }
  }
}

TEST_F(RunOrder, changes_no_gradient) {
  using cuda::train::GpuModel;
  auto scene = test::small_scene<float>(3000, 11);
  for (float& logit : scene.opacity_logits) logit -= 2;
  scene.log_scales[0] = glm::vec3(1);
  for (const char* mode : {"3dgs", "quadbox", "exact"}) {
    SCOPED_TRACE(mode);
    std::vector<std::vector<float>> expected;
    for (unsigned order = 0; order <= kOrders; ++order) {
      emulator::run_order = order;
      GpuModel model;
      model.set_state(train::ModelState::starting_with(scene));
      model.forward(test::front_camera(test::kWidth, test::kHeight),
                    test::settings_of(find_culler(mode), false));
      model.set_pixel_gradients(test::pixel_weights<float>());
      model.backward({.absolute = true});
      const std::vector<std::uint8_t> black(3 * test::kWidth * test::kHeight);
      model.count_errors(0, {black, {}, {}});
      auto gradients = test::groups_of(model.gradients().by);
      gradients.emplace_back();
      for (const glm::vec2& sums : model.gradients().absolute_px)
        gradients.back().insert(gradients.back().end(), {sums.x, sums.y});
      const train::PixelCounts& counts = model.facts().counts;
      gradients.emplace_back(counts.flagged.begin(), counts.flagged.end());
      if (order == 0) expected = gradients;
      EXPECT_EQ(gradients, expected) << order;
    }
  }
}

// A colour field and codes of shapes, over two iterations.
TEST_F(RunOrder, changes_no_value_of_a_colour_field) {
  train::ModelState state = train::ModelState::starting_with(test::small_scene<float>(700, 11));
  state.color_field = train::FieldState::starting_with(test::tiny_field());
  state.codes = train::first_codes(state, 1, test::pool());
  std::vector<std::vector<float>> expected;
  for (unsigned order = 0; order <= kOrders; ++order) {
    emulator::run_order = order;
    cuda::train::GpuModel model;
    model.set_state(state);
    for (int iteration = 1; iteration <= 2; ++iteration) {
      model.forward(test::front_camera(test::kWidth, test::kHeight),
                    test::settings_of(find_culler("quadbox"), false));
      model.set_pixel_gradients(test::pixel_weights<float>());
      model.backward({});
      train::StepOrder step = test::counted_step({1e-3, 1e-3, 1e-3, 1e-3, 0, 0, 0});
      step.field_rate = 0.01;
      model.step(step);
    }
    const train::ModelState& moved = model.state();
    auto values = test::groups_of(moved.parameters);
    values.push_back(moved.color_field.field.grid_values);
    values.push_back(moved.color_field.field.weights);
    values.push_back(moved.codes.scales.codebook.values);
    values.push_back(moved.codes.rotations.codebook.values);
    if (order == 0) expected = values;
    EXPECT_EQ(values, expected) << order;
  }
  EXPECT_NE(expected.back(), state.codes.rotations.codebook.values);
}

}  // namespace
}  // namespace qs
