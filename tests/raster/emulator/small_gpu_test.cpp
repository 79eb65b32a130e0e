// SPDX-License-Identifier: MIT
// Memory of a small GPU: what can be copied again makes room for what is needed now.
#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

#include "cuda_runtime.h"
#include "io/camera/lens_views.h"
#include "learn/step/cuda/gpu_model.h"
#include "support/golden_field.h"
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
    emulator::multiprocessors = emulator::kMultiprocessors;
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

// Full macro-tiles are sorted whole in the small picture and cut into slices in the larger picture.
TEST_F(SmallGpu, of_any_number_of_multiprocessors_draws_the_same_pictures) {
  const GaussianCloud cloud =
      test::scattered_cloud(30'000, 512, [](std::size_t i) { return 2 + 1e-4 * double(i); });
  std::vector<std::vector<float>> first;
  for (const int multiprocessors : {24, 1, 5}) {
    SCOPED_TRACE(multiprocessors);
    emulator::multiprocessors = multiprocessors;
    const auto renderer = make_renderer(Backend::cuda, test::pool());
    renderer->upload(cloud, {});
    std::vector<std::vector<float>> pictures;
    for (const int side : {512, 24, 512})
      pictures.push_back(renderer->render(test::front_camera(side, side)).color.values);
    if (first.empty()) first = pictures;
    EXPECT_EQ(pictures, first);
  }
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

// A macro-tile that `fast` cannot cut: at every distance between its samples (16 to 64 entries) the
// samples are the farther Gaussians, so the nearer ones stay in one slice. Faint Gaussians far away
// make the cells of the spatial order so large that it is the order of the file. `classic` needs
// the scene in another order, and both do not fit into memory together.
GaussianCloud uncut_cloud() {
  constexpr std::uint32_t kBlock = 256, kCount = 117 * kBlock, kFaint = 16 * kBlock;
  const auto is_sample = [](std::uint32_t slot, unsigned log2_distance) {
    const std::uint32_t number = slot >> log2_distance;
    return slot == (number << log2_distance | (number * 2654435761u) >> (32 - log2_distance));
  };
  GaussianCloud cloud;
  cloud.resize(kCount + kFaint, 3);
  for (std::uint32_t i = 0; i < kCount + kFaint; ++i) {
    // Blocks append in reverse order, as the farthest ones are projected first.
    const std::uint32_t slot = kCount - (i / kBlock + 1) * kBlock + i % kBlock;
    const bool far = is_sample(slot, 6) || is_sample(slot, 5) || is_sample(slot, 4);
    const float faint_z = i % 2 == 0 ? -1000.0f : 1000.0f;
    const float z = i < kCount ? (far ? 2.5f : 2.0f) + 1e-6f * static_cast<float>(i) : faint_z;
    cloud.positions[i] = {0, 0, z};
    cloud.log_scales[i] = glm::vec3(-2);
    cloud.rotations[i] = {1, 0, 0, 0};
    cloud.opacity_logits[i] = i < kCount ? -2 : -20;
  }
  std::fill(cloud.sh.begin(), cloud.sh.end(), glm::vec3(0.1f));  // not exact in half precision
  return cloud;
}

TEST_F(SmallGpu, a_scene_that_fast_gave_up_is_not_uploaded_twice_for_each_frame) {
  constexpr int kRest = 100;  // frames until `fast` is tried again
  const GaussianCloud cloud = uncut_cloud();
  const auto renderer = make_renderer(Backend::cuda, test::pool());
  renderer->upload(cloud, {});
  leave(10 << 20);  // for one of the orders, of 7 MiB, and the buffers of a frame
  const Camera camera = test::front_camera(32, 32);
  const auto uploaded_by_a_frame = [&] {
    const std::size_t before = emulator::uploaded_bytes;
    EXPECT_EQ(renderer->render(camera).stats.pipeline, Pipeline::classic);
    return emulator::uploaded_bytes - before;
  };
  const std::size_t order = uploaded_by_a_frame();  // of classic
  EXPECT_GT(order, std::size_t{6} << 20);
  for (int frame = 1; frame < kRest; ++frame) EXPECT_LT(uploaded_by_a_frame(), order / 10) << frame;
  EXPECT_GT(uploaded_by_a_frame(), order + order / 2) << "fast is tried again";
  EXPECT_LT(uploaded_by_a_frame(), order / 10);
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
  QS_EMULATED_BEFORE_A_RELEASE();
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

TEST_F(SmallGpu, lanes_of_faces_end_where_memory_does) {
  const GaussianCloud cloud = test::surrounding_cloud(8'000, 0, 8);
  RenderSettings settings;
  settings.lens = std::make_shared<const LensView>(panorama_view(360));
  const Camera camera = test::front_camera(128, 64);
  setenv("QUADSPLAT_LANES", "24", 1);
  const auto plenty = make_renderer(Backend::cuda, test::pool());
  plenty->upload(cloud, {});
  const Frame whole = plenty->render(camera, settings);
  const std::size_t used_by_lanes = emulator::used_bytes;
  for (const std::size_t megabytes : {3, 8}) {
    SCOPED_TRACE(megabytes);
    const auto renderer = make_renderer(Backend::cuda, test::pool());
    renderer->upload(cloud, {});
    leave(megabytes << 20);
    const Frame& frame = renderer->render(camera, settings);
    EXPECT_EQ(frame.color.values, whole.color.values);
    EXPECT_EQ(frame.stats.tile_pairs, whole.stats.tile_pairs);
    EXPECT_LT(emulator::used_bytes, emulator::total_bytes);
    emulator::total_bytes = emulator::kTotalBytes;
  }
  unsetenv("QUADSPLAT_LANES");
  EXPECT_GT(used_by_lanes, std::size_t{24} * cloud.size() * 104);
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

TEST_F(SmallGpu, a_colour_field_that_does_not_fit_is_refused_and_a_smaller_one_trains) {
  train::ModelState state = train::ModelState::starting_with(test::small_scene<float>(50, 1));
  state.color_field = train::FieldState::starting_with(test::published_field());
  cuda::train::GpuModel model;
  leave(100 << 20);
  EXPECT_THROW(model.set_state(state), Error);
  state.color_field = train::FieldState::starting_with(test::tiny_field());
  model.set_state(state);
  model.forward(test::front_camera(test::kWidth, test::kHeight),
                test::settings_of(default_mode(), false));
  model.set_pixel_gradients(test::pixel_weights<float>());
  model.backward({});
  EXPECT_NE(model.field_gradients().grid,
            std::vector<double>(state.color_field.field.grid_values.size()));
}

}  // namespace
}  // namespace qs
