// SPDX-License-Identifier: MIT
// The forward and the backward pass of training on the GPU: against the passes of the CPU.
#include "learn/step/cpu/passes.h"
#include "learn/step/cuda/gpu_model.h"
#include "support/gpu.h"
#include "support/scenes.h"
#include "support/train_scenes.h"

namespace qs::cuda::train {
namespace {

using test::groups_of;
using test::kHeight;
using test::kWidth;
using test::pixel_weights;
using test::settings_of;
using test::small_scene;
using test::start;
using Scene = cpu::train::Parameters<float>;

class CudaTrainFrame : public test::GpuTest {};

struct Result {
  PixelCopies pixels;
  Scene by;
  std::vector<glm::vec2> mean_px;
  std::vector<std::uint8_t> visible;
  std::vector<glm::vec2> absolute_px = {};
};

constexpr qs::train::BackwardOrder kAbsolute{.absolute = true};

Result on_gpu(const Scene& scene, const RenderSettings& settings, int width = kWidth,
              int height = kHeight, const qs::train::BackwardOrder& order = {},
              Projection projection = Projection::pinhole) {
  GpuModel model;
  start(model, scene);
  model.forward(test::with_projection(test::front_camera(width, height), projection), settings);
  model.set_pixel_gradients(pixel_weights<float>(width, height));
  model.backward(order);
  const GradientCopies gradients = model.gradients();
  return {model.pixels(), gradients.by, gradients.mean_px, gradients.visible,
          gradients.absolute_px};
}

Result on_cpu(const Scene& scene, const RenderSettings& settings,
              cpu::train::ForwardFrame<float>& frame, int width = kWidth, int height = kHeight,
              const qs::train::BackwardOrder& order = {},
              Projection projection = Projection::pinhole) {
  const Camera camera = test::with_projection(test::front_camera(width, height), projection);
  const cpu::train::StepView view{camera, settings, test::pool()};
  cpu::train::BackwardScratch<float> scratch;
  cpu::train::Gradients<float> gradients;
  forward(view, scene, frame);
  cpu::train::backward<float>(view, scene, frame, pixel_weights<float>(width, height), scratch,
                              gradients, order);
  return {{frame.color, frame.transmittance, frame.last},
          gradients.by,
          gradients.mean_px,
          gradients.visible,
          gradients.absolute_px};
}

Result on_cpu(const Scene& scene, const RenderSettings& settings) {
  cpu::train::ForwardFrame<float> frame;
  return on_cpu(scene, settings, frame);
}

/// Expects that all values agree up to 1e-4 times the largest expected one.
void expect_close(const std::vector<float>& values, const std::vector<float>& expected) {
  ASSERT_EQ(values.size(), expected.size());
  float scale = 0;
  for (const float value : expected) scale = std::max(scale, std::abs(value));
  EXPECT_GT(scale, 0);
  for (std::size_t i = 0; i < values.size(); ++i)
    ASSERT_NEAR(values[i], expected[i], 1e-4f * scale) << "value " << i;
}

void expect_close(const Result& result, const Result& expected) {
  EXPECT_EQ(result.visible, expected.visible);
  const auto groups = groups_of(result.by), expected_groups = groups_of(expected.by);
  for (std::size_t group = 0; group < groups.size(); ++group) {
    SCOPED_TRACE(testing::Message() << "group " << group);
    expect_close(groups[group], expected_groups[group]);
  }
  const auto flat = [](const std::vector<glm::vec2>& pairs) {
    std::vector<float> values;
    for (const glm::vec2& pair : pairs) values.insert(values.end(), {pair.x, pair.y});
    return values;
  };
  expect_close(flat(result.mean_px), flat(expected.mean_px));
  ASSERT_EQ(result.absolute_px.size(), expected.absolute_px.size());
  if (!expected.absolute_px.empty())
    expect_close(flat(result.absolute_px), flat(expected.absolute_px));
}

/// Their zeros may have another sign: a pair that reaches no pixel adds 0.
void expect_equal_gradients(const Result& result, const Result& expected) {
  EXPECT_EQ(groups_of(result.by), groups_of(expected.by));
  EXPECT_EQ(result.mean_px, expected.mean_px);
  EXPECT_EQ(result.visible, expected.visible);
}

// One tile lists all Gaussians, many of them at equal depths. The emulated GPU sorts up to 3,072
// and 4,096 of them in the shared memory of a block.
TEST_F(CudaTrainFrame, long_lists_are_sorted_by_depth_then_by_index) {
  for (const std::size_t count : {3000u, 3500u, 4500u}) {
    Scene scene = small_scene<float>(count, 1);
    for (std::size_t i = 0; i < count; ++i) {
      scene.means[i].z = 2 + static_cast<float>(i % 40) / 16;
      scene.opacity_logits[i] = -5;
    }
    const RenderSettings settings = settings_of(find_culler("3dgs"), false);
    cpu::train::ForwardFrame<float> frame;
    const Result expected = on_cpu(scene, settings, frame, kTileSize, kTileSize);
    EXPECT_GT(frame.lists.pairs(), count * 9 / 10);
    const Result result = on_gpu(scene, settings, kTileSize, kTileSize);
    for (std::size_t i = 0; i < expected.pixels.color.size(); ++i) {
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(result.pixels.color[i][c], expected.pixels.color[i][c], 2e-5) << count;
    }
    expect_close(result, expected);
  }
}

TEST_F(CudaTrainFrame, pixels_equal_those_of_the_cpu) {
  for (const bool antialiased : {false, true}) {
    const Scene scene = small_scene<float>(500, 1);
    const RenderSettings settings = settings_of(default_mode(), antialiased);
    const PixelCopies pixels = on_gpu(scene, settings).pixels;
    const PixelCopies expected = on_cpu(scene, settings).pixels;
    std::size_t different = 0;
    for (std::size_t i = 0; i < expected.color.size(); ++i) {
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(pixels.color[i][c], expected.color[i][c], 2e-5);
      ASSERT_NEAR(pixels.transmittance[i], expected.transmittance[i], 2e-5);
      different += pixels.last[i] != expected.last[i];
    }
    // An alpha of about 1/255 may count on one side only.
    EXPECT_LE(different, expected.last.size() / 1000);
  }
}

TEST_F(CudaTrainFrame, gradients_equal_those_of_the_cpu_in_every_mode) {
  const Scene scene = test::with_masks(small_scene<float>(300, 5));
  for (const CullMode mode : test::tiled_modes()) {
    for (const bool antialiased : {false, true}) {
      SCOPED_TRACE(testing::Message() << mode_name(mode) << (antialiased ? ", antialiased" : ""));
      const RenderSettings settings = settings_of(mode, antialiased);
      expect_close(on_gpu(scene, settings), on_cpu(scene, settings));
    }
  }
}

TEST_F(CudaTrainFrame, gradients_of_a_face_equal_those_of_the_cpu) {
  const Scene scene = test::with_masks(small_scene<float>(300, 5));
  for (const bool antialiased : {false, true}) {
    const RenderSettings settings = settings_of(default_mode(), antialiased);
    cpu::train::ForwardFrame<float> frame;
    expect_close(on_gpu(scene, settings, kWidth, kHeight, {}, Projection::face),
                 on_cpu(scene, settings, frame, kWidth, kHeight, {}, Projection::face));
  }
}

TEST_F(CudaTrainFrame, every_lossless_mode_gives_the_same_gradients) {
  // The lists of the second scene have several segments, which begin at other Gaussians in each
  // mode.
  for (const Scene& scene : {small_scene<float>(400, 7), small_scene<float>(3000, 11)}) {
    const Result expected = on_gpu(scene, settings_of(find_culler("adr"), false));
    for (const CullMode mode : test::tiled_modes()) {
      // Mode 3dgs keeps Gaussians of alpha < 1/255 but loses some pixels of other Gaussians.
      if (!row_of(mode).lossless) continue;
      SCOPED_TRACE(mode_name(mode));
      expect_equal_gradients(on_gpu(scene, settings_of(mode, false)), expected);
    }
  }
}

TEST_F(CudaTrainFrame, absolute_gradients_equal_those_of_the_cpu_and_change_no_other_gradient) {
  for (const std::size_t count : {300u, 3000u}) {  // one segment, several segments
    const Scene scene = small_scene<float>(count, 7);
    const RenderSettings settings = settings_of(find_culler("adr"), false);
    const Result expected = on_gpu(scene, settings, kWidth, kHeight, kAbsolute);
    EXPECT_EQ(expected.absolute_px.size(), count);
    expect_equal_gradients(on_gpu(scene, settings), expected);
    cpu::train::ForwardFrame<float> frame;
    expect_close(expected, on_cpu(scene, settings, frame, kWidth, kHeight, kAbsolute));
    for (const char* mode : {"quadbox", "exact"}) {
      const Result result =
          on_gpu(scene, settings_of(find_culler(mode), false), kWidth, kHeight, kAbsolute);
      EXPECT_EQ(result.absolute_px, expected.absolute_px) << mode;
    }
  }
}

TEST_F(CudaTrainFrame, two_runs_give_the_same_bits) {
  const Scene scene = small_scene<float>(1000, 9);
  const RenderSettings settings = settings_of(default_mode(), true);
  const Result first = on_gpu(scene, settings), second = on_gpu(scene, settings);
  expect_equal_gradients(second, first);
  EXPECT_EQ(second.pixels.color, first.pixels.color);
}

TEST_F(CudaTrainFrame, long_lists_give_the_gradients_of_the_cpu_also_where_pixels_stop) {
  for (const bool opaque : {false, true}) {
    Scene scene = small_scene<float>(3000, 11);
    for (float& logit : scene.opacity_logits) logit += opaque ? 5 : -2;
    const RenderSettings settings = settings_of(find_culler("quadbox"), false);
    cpu::train::ForwardFrame<float> frame;
    const Result expected = on_cpu(scene, settings, frame);
    std::size_t stopped = 0;
    std::uint32_t longest = 0, deepest = 0;
    for (std::size_t tile = 0; tile + 1 < frame.lists.begin.size(); ++tile)
      longest = std::max(longest, frame.lists.pairs(tile));
    for (std::size_t i = 0; i < frame.last.size(); ++i) {
      stopped += frame.transmittance[i] < 0.01f;
      deepest = std::max(deepest, frame.last[i]);
    }
    EXPECT_GT(longest, 300u);
    EXPECT_GT(opaque ? stopped : deepest, opaque ? frame.last.size() / 2 : 300u);
    expect_close(on_gpu(scene, settings), expected);
  }
}

TEST_F(CudaTrainFrame, large_gaussians_in_large_views_are_listed_in_the_order_of_tiles) {
  QS_EMULATED_BEFORE_A_RELEASE();
  Scene scene = small_scene<float>(6, 19);
  for (glm::vec3& log_scale : scene.log_scales) log_scale += 1.0f;
  scene.log_scales[0] = glm::vec3(2);  // covers the view
  for (const char* mode : {"3dgs", "quadbox", "quadbox-naive", "exact"}) {
    // Lines of tiles are columns in the first view, more than a warp has lanes; rows in the second.
    for (const auto& [width, height] : {std::pair{560, 600}, {600, 300}}) {
      SCOPED_TRACE(testing::Message() << mode << " " << width << "x" << height);
      const RenderSettings settings = settings_of(find_culler(mode), false);
      cpu::train::ForwardFrame<float> frame;
      const Result expected = on_cpu(scene, settings, frame, width, height);
      for (std::size_t tile = 0; tile + 1 < frame.lists.begin.size(); ++tile)
        ASSERT_GT(frame.lists.pairs(tile), 0u);
      expect_close(on_gpu(scene, settings, width, height), expected);
    }
  }
}

TEST_F(CudaTrainFrame, coefficients_above_the_degree_get_no_gradient) {
  const Scene scene = small_scene<float>(50, 13);
  RenderSettings settings = settings_of(default_mode(), false);
  settings.sh_degree = 1;
  const Result result = on_gpu(scene, settings);
  expect_close(result, on_cpu(scene, settings));
  for (std::size_t k = 4; k < scene.sh_stride(); ++k) EXPECT_EQ(result.by.sh[k], glm::vec3(0));
}

TEST_F(CudaTrainFrame, gaussians_outside_of_the_view_get_no_gradient) {
  Scene scene = small_scene<float>(3, 11);
  scene.means[1].z = -3;
  const Result result = on_gpu(scene, settings_of(default_mode(), false));
  EXPECT_EQ(result.visible, (std::vector<std::uint8_t>{1, 0, 1}));
  EXPECT_EQ(result.by.means[1], glm::vec3(0));
  EXPECT_NE(result.by.means[0], glm::vec3(0));
}

TEST_F(CudaTrainFrame, a_view_that_shows_nothing_is_the_background_and_flat) {
  Scene scene = small_scene<float>(40, 15);
  for (glm::vec3& mean : scene.means) mean.z = -mean.z;
  const RenderSettings settings = settings_of(default_mode(), false);
  const Result result = on_gpu(scene, settings);
  for (const glm::vec3& color : result.pixels.color) ASSERT_EQ(color, settings.background);
  for (const auto& group : groups_of(result.by)) {
    for (const float value : group) ASSERT_EQ(value, 0);
  }
  EXPECT_EQ(result.visible, std::vector<std::uint8_t>(40, 0));
}

TEST_F(CudaTrainFrame, a_cancelled_pass_throws_and_the_next_one_works) {
  const Scene scene = small_scene<float>(20, 17);
  GpuModel model;
  start(model, scene);
  std::stop_source stop;
  stop.request_stop();
  const Camera camera = test::front_camera(kWidth, kHeight);
  const RenderSettings settings = settings_of(default_mode(), false);
  EXPECT_THROW(model.forward(camera, settings, stop.get_token()), Cancelled);
  model.forward(camera, settings);
  EXPECT_EQ(model.pixels().color, on_gpu(scene, settings).pixels.color);
}

}  // namespace
}  // namespace qs::cuda::train
