// SPDX-License-Identifier: MIT
// Memory of a small GPU: what can be copied again makes room for what is needed now.
#include <gtest/gtest.h>

#include "cuda_runtime.h"
#include "raster/cuda/train/gpu_model.h"
#include "support/gpu.h"
#include "support/scenes.h"
#include "support/train_scenes.h"

namespace qs {
namespace {

class SmallGpu : public testing::Test {
 protected:
  void TearDown() override {
    emulator::total_bytes = emulator::kTotalBytes;
    emulator::fails_to_instantiate = false;
  }
  /// Leaves this many bytes free.
  static void leave(std::size_t bytes) { emulator::total_bytes = emulator::used_bytes + bytes; }
};

std::vector<float> drawn(Renderer& renderer, Pipeline pipeline = Pipeline::fast) {
  RenderSettings settings;
  settings.pipeline = pipeline;
  return renderer.render(test::front_camera(64, 48), settings).color.values;
}

TEST_F(SmallGpu, a_failed_upload_leaves_the_old_scene_drawn) {
  const auto renderer = make_renderer(Backend::cuda, test::pool());
  renderer->upload(test::random_cloud(2000, 3, 1), {});
  const std::vector<float> before = drawn(*renderer);
  leave(1 << 20);
  EXPECT_THROW(renderer->upload(test::random_cloud(200'000, 3, 2), {}), Error);
  EXPECT_EQ(drawn(*renderer), before);
  std::stop_source stopped;
  stopped.request_stop();
  EXPECT_THROW(renderer->upload(test::random_cloud(2000, 3, 3), {{}, stopped.get_token()}),
               Cancelled);
  EXPECT_EQ(drawn(*renderer), before);
}

TEST_F(SmallGpu, the_old_scene_goes_before_the_new_one_comes) {
  const auto renderer = make_renderer(Backend::cuda, test::pool());
  renderer->upload(test::random_cloud(50'000, 3, 1), {});
  drawn(*renderer);
  leave(6 << 20);  // less than a scene
  renderer->upload(test::random_cloud(50'000, 3, 2), {});
  const std::vector<float> small = drawn(*renderer);
  emulator::total_bytes = emulator::kTotalBytes;
  const auto alone = make_renderer(Backend::cuda, test::pool());
  alone->upload(test::random_cloud(50'000, 3, 2), {});
  EXPECT_EQ(small, drawn(*alone));
}

TEST_F(SmallGpu, the_other_order_of_the_scene_and_old_buffers_make_room_for_a_frame) {
  const auto renderer = make_renderer(Backend::cuda, test::pool());
  renderer->upload(test::random_cloud(20'000, 3, 1), {});
  drawn(*renderer, Pipeline::fast);
  drawn(*renderer, Pipeline::classic);
  leave(0);
  const Camera camera = test::front_camera(320, 200);  // needs larger buffers
  const std::vector<float> small = renderer->render(camera).color.values;
  emulator::total_bytes = emulator::kTotalBytes;
  EXPECT_EQ(small, renderer->render(camera).color.values);
}

// Gaussians of one depth cannot be cut into slices, so `fast` gives up. `classic` needs the scene
// in the order of the file, which does not fit into memory beside the other order.
TEST_F(SmallGpu, a_scene_that_fast_gave_up_is_not_uploaded_twice_for_each_frame) {
  constexpr int kRest = 100;  // frames until `fast` is tried again
  const GaussianCloud cloud = test::scattered_cloud(30'000, 32, [](std::size_t) { return 2.0; });
  const auto renderer = make_renderer(Backend::cuda, test::pool());
  const std::size_t before = emulator::uploaded_bytes;
  renderer->upload(cloud, {});
  const std::size_t scene = emulator::uploaded_bytes - before;
  ASSERT_GT(scene, 100'000u);
  const Camera camera = test::front_camera(32, 32);
  const auto uploads_of_a_frame = [&] {
    const std::size_t uploaded = emulator::uploaded_bytes;
    EXPECT_EQ(renderer->render(camera).stats.pipeline, Pipeline::classic);
    return static_cast<double>(emulator::uploaded_bytes - uploaded) / static_cast<double>(scene);
  };
  leave(scene * 3 / 2);
  EXPECT_NEAR(uploads_of_a_frame(), 1, 0.5) << "the order of classic";
  for (int frame = 1; frame < kRest; ++frame) EXPECT_LT(uploads_of_a_frame(), 0.1) << frame;
  EXPECT_NEAR(uploads_of_a_frame(), 2, 0.5) << "fast is tried again";
  EXPECT_LT(uploads_of_a_frame(), 0.1);
}

// A crop uploads another cloud to the same renderer, and the whole scene comes back after it.
TEST_F(SmallGpu, a_crop_and_the_whole_scene_take_each_other_s_place) {
  const GaussianCloud whole = test::random_cloud(50'000, 3, 1),
                      part = test::random_cloud(40'000, 3, 2);
  const auto renderer = make_renderer(Backend::cuda, test::pool());
  renderer->upload(whole, {});
  const std::vector<float> before = drawn(*renderer);
  leave(6 << 20);  // less than either
  renderer->upload(part, {});
  EXPECT_NE(drawn(*renderer), before);
  renderer->upload(whole, {});
  EXPECT_EQ(drawn(*renderer), before);
}

TEST_F(SmallGpu, photographs_make_room_for_growth_and_are_copied_again) {
  using namespace cuda::train;
  constexpr std::size_t kPixels = test::kWidth * test::kHeight, kPhotographs = 200;
  GpuModel model;
  test::start(model, test::small_scene<float>(1000, 1));
  const std::vector<std::uint8_t> rgb(3 * kPixels, 100);
  const auto loss_of = [&](std::size_t number) {
    model.forward(test::front_camera(test::kWidth, test::kHeight),
                  test::settings_of(default_mode(), false));
    model.compare_with(number, {rgb, {}, {}});
    return model.loss().total;
  };
  const double loss = loss_of(0);
  for (std::size_t number = 1; number < kPhotographs; ++number) loss_of(number);
  leave(1 << 10);
  train::Plan plan;
  plan.keep_all(model.facts(), 2);
  plan.resets_statistics = true;
  model.apply(plan);  // needs a second copy of the model
  EXPECT_EQ(model.size(), 1000u);
  emulator::total_bytes += 64 << 10;
  EXPECT_EQ(loss_of(0), loss);
}

TEST_F(SmallGpu, photographs_are_kept_while_they_leave_half_of_the_free_memory) {
  using namespace cuda::train;
  constexpr std::size_t kPixels = test::kWidth * test::kHeight;
  GpuModel model;
  test::start(model, test::small_scene<float>(50, 1));
  const std::vector<std::uint8_t> rgb(3 * kPixels, 100);
  model.forward(test::front_camera(test::kWidth, test::kHeight),
                test::settings_of(default_mode(), false));
  model.compare_with(0, {rgb, {}, {}});
  leave(10 * rgb.size());
  for (std::size_t number = 1; number < 100; ++number) model.compare_with(number, {rgb, {}, {}});
  EXPECT_LT(emulator::used_bytes, emulator::total_bytes);
}

TEST_F(SmallGpu, a_graph_that_cannot_be_instantiated_is_destroyed) {
  const auto renderer = make_renderer(Backend::cuda, test::pool());
  renderer->upload(test::random_cloud(100, 0, 1), {});
  const int before = emulator::captured_graphs;
  emulator::fails_to_instantiate = true;
  EXPECT_THROW(drawn(*renderer), Error);
  EXPECT_EQ(emulator::captured_graphs, before);
  emulator::fails_to_instantiate = false;
  EXPECT_FALSE(drawn(*renderer).empty());
}

TEST_F(SmallGpu, fast_draws_with_the_dilation_of_reduced_frames) {
  const auto renderer = make_renderer(Backend::cuda, test::pool());
  const auto cpu = make_renderer(Backend::cpu, test::pool());
  const GaussianCloud cloud = test::random_cloud(2000, 1, 4);
  renderer->upload(cloud, {});
  cpu->upload(cloud, {});
  const Camera camera = test::front_camera(96, 64);
  for (const int divisor : {1, 2, 3, 8}) {
    RenderSettings settings;
    settings.dilation = kDilation / (divisor * divisor);
    const Frame& frame = renderer->render(camera, settings);
    EXPECT_EQ(frame.stats.pipeline, Pipeline::fast) << divisor;
    const Image expected = cpu->render(camera, settings).color;
    double largest = 0;
    for (std::size_t i = 0; i < expected.values.size(); ++i)
      largest =
          std::max(largest, std::abs(double{frame.color.values[i]} - double{expected.values[i]}));
    EXPECT_LT(largest, 1e-3) << divisor;
  }
}

}  // namespace
}  // namespace qs
