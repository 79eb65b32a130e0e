// SPDX-License-Identifier: MIT
// Outputs::seen and share of the CUDA backend against the CPU backend.
#include "raster/select/by_shape.h"
#include "support/gpu.h"
#include "support/scenes.h"

namespace qs {
namespace {

using CudaSelection = test::PipelineTest;
INSTANTIATE_TEST_SUITE_P(Pipelines, CudaSelection, test::kPipelines, test::name_of_pipeline);

Outputs outputs_for(const Shape& shape, glm::ivec2 size, float weight, const GaussianSet& set) {
  Outputs outputs;
  outputs.seen = pixels_in(shape, size, weight, test::pool());
  outputs.share = std::make_shared<const GaussianSet>(set);
  return outputs;
}

TEST_P(CudaSelection, is_that_of_the_cpu_but_for_weights_next_to_the_limit) {
  constexpr float kMargin = 1e-4f;
  const GaussianCloud cloud = test::random_cloud(1500, 1, 42);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  const std::vector<glm::dvec2> stroke = {{10, 40}, {45, 20}, {89, 33}};
  const std::vector<glm::dvec2> corners = {{5, 5}, {80, 12}, {30, 60}, {60, 2}};
  const GaussianSet set =
      GaussianSet::where(cloud.size(), test::pool(), [](std::size_t i) { return i % 3 == 0; });
  for (const glm::ivec2 size : {glm::ivec2(1, 1), {17, 33}, {96, 64}}) {
    const Camera camera = test::front_camera(size.x, size.y);
    for (const Shape& shape : {Shape::rectangle({-9, -9}, {999, 999}), Shape::stroke(stroke, 4),
                               Shape::polygon(corners), Shape::rectangle({3, 3}, {3, 3})})
      for (const float weight : {0.0f, 0.01f, 0.05f, 0.5f}) {
        const auto on = [&](Renderer& renderer, float at) {
          return renderer.render(camera, settings_of_pipeline(), outputs_for(shape, size, at, set));
        };
        const Frame frame = on(*gpu, weight);
        // Weights of the CPU are above or below the limit with a margin.
        const GaussianSet sure = on(*cpu, weight + kMargin).seen;
        const Frame expected = on(*cpu, std::max(weight - kMargin, 0.0f));
        GaussianSet missed = sure, wrong = frame.seen;
        missed -= frame.seen;
        wrong -= expected.seen;
        EXPECT_TRUE(missed.empty());
        EXPECT_TRUE(weight == 0 || wrong.empty());
        ASSERT_EQ(frame.share.size(), expected.share.size());
        for (std::size_t i = 0; i < frame.share.size(); ++i)
          EXPECT_NEAR(frame.share[i], expected.share[i], 2e-3f) << i;
      }
  }
}

TEST_P(CudaSelection, leaves_the_frame_as_it_is_and_follows_sets_of_drawn_gaussians) {
  const GaussianCloud cloud = test::surrounding_cloud(1500, 1, 8);
  const auto gpu = renderer_of(Backend::cuda, cloud);
  const glm::ivec2 size(96, 64);
  const Camera camera = test::front_camera(size.x, size.y);
  const GaussianSet odd =
      GaussianSet::where(cloud.size(), test::pool(), [](std::size_t i) { return i % 2 == 1; });
  const Outputs outputs = outputs_for(Shape::rectangle({0, 0}, {96, 64}), size, 0.01f, odd);
  const Image plain = gpu->render(camera, settings_of_pipeline()).color;
  Frame frame = gpu->render(camera, settings_of_pipeline(), outputs);
  EXPECT_EQ(frame.color.values, plain.values);
  GaussianSet even = frame.seen;
  even -= odd;
  EXPECT_FALSE(even.empty());
  gpu->set_drawn(odd);
  frame = gpu->render(camera, settings_of_pipeline(), outputs);
  GaussianSet others = frame.seen;
  others -= odd;
  EXPECT_TRUE(others.empty());
  EXPECT_FALSE(frame.seen.empty());
  const Frame& bare = gpu->render(camera, settings_of_pipeline());
  EXPECT_TRUE(bare.share.empty());
  EXPECT_EQ(bare.seen.size(), 0u);
}

TEST_P(CudaSelection, of_an_empty_scene_is_empty) {
  GaussianCloud empty;
  empty.resize(0, 0);
  const auto gpu = renderer_of(Backend::cuda, empty);
  const glm::ivec2 size(40, 24);
  const Frame& frame =
      gpu->render(test::front_camera(size.x, size.y), settings_of_pipeline(),
                  outputs_for(Shape::rectangle({0, 0}, {40, 24}), size, 0, GaussianSet(0)));
  EXPECT_TRUE(frame.seen.empty());
  EXPECT_EQ(frame.share, std::vector<float>(40 * 24));
}

}  // namespace
}  // namespace qs
