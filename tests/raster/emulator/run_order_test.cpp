// SPDX-License-Identifier: MIT
// The order in which a GPU runs blocks and threads changes no bit of a picture or of a gradient.
#include <cmath>
#include <random>

#include "cuda_runtime.h"
#include "raster/cuda/train/gpu_model.h"
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

/// `count` Gaussians in front of a camera of `side` x `side` pixels, most of them small; every
/// fourth depth is that of another one.
GaussianCloud crowd(std::size_t count, int side) {
  std::mt19937 random(5);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const Camera camera = test::front_camera(side, side);
  GaussianCloud cloud;
  cloud.resize(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const double z = i % 4 == 3 ? cloud.positions[i - 1].z : uniform(2, 6);
    const double px = z / camera.focal_px.x;
    cloud.positions[i] = {uniform(-0.5, 0.5) * side * px, uniform(-0.5, 0.5) * side * px, z};
    const double size = i % 500 == 0 ? uniform(0.1, 1) * side : std::exp(uniform(-1, 1.5));
    for (int axis = 0; axis < 3; ++axis)
      cloud.log_scales[i][axis] = static_cast<float>(std::log(size * px * uniform(0.2, 1)));
    cloud.rotations[i] = glm::quat(1, 0, 0, 0);
    cloud.opacity_logits[i] = static_cast<float>(uniform(-5, 0));
    cloud.sh[i] = glm::vec3(uniform(-1.7, 1.7), uniform(-1.7, 1.7), uniform(-1.7, 1.7));
  }
  return cloud;
}

// Usual macro-tiles, full ones, ones that are cut into slices, and lists that are cut by depth.
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
        renderer->upload(crowd(count, 32), {});
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
      model.backward();
      const auto gradients = test::groups_of(model.gradients().by);
      if (order == 0) expected = gradients;
      EXPECT_EQ(gradients, expected) << order;
    }
  }
}

}  // namespace
}  // namespace qs
