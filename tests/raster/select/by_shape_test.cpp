// SPDX-License-Identifier: MIT
//
// Gaussians under a shape, against the weights of a frame in double precision.
#include "raster/select/by_shape.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "raster/kernel/composite.h"
#include "raster/kernel/constants.h"
#include "raster/scene/cloud_order.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs::test {
namespace {

constexpr int kSide = 90;
constexpr double kMargin = 1e-4;  // of weights

class SelectedByShape : public testing::TestWithParam<Pipeline> {
 protected:
  SelectedByShape() { renderer_->upload(GaussianCloud(cloud_), {}); }

  const Frame& frame(CullMode mode, const Outputs& outputs = {.color = false, .trace = true}) {
    RenderSettings settings;
    settings.mode = mode;
    settings.pipeline = GetParam();
    return renderer_->render(camera_, settings, outputs);
  }

  GaussianSet seen(CullMode mode, const Shape& shape, float weight) {
    Outputs outputs{.color = false};
    outputs.seen = pixels_in(shape, {kSide, kSide}, weight, pool());
    return frame(mode, outputs).seen;
  }

  // The largest weight of each Gaussian at pixels in the shape, from all Gaussians in order of
  // depth; -1: none blends it.
  std::vector<double> weights(const Shape& shape) {
    const Trace& trace = frame(default_mode()).trace;
    std::vector<std::size_t> order(trace.gaussians.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t slot) { return trace.depths[slot]; });
    std::vector<double> largest(cloud_.size(), -1);
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        if (!shape.contains(glm::dvec2(x, y))) continue;
        double left = 1;
        for (const std::size_t slot : order) {
          const Splat& s = trace.splats[slot];
          const SplatOf<double> splat{s.mean_px, s.log2_conic, s.opacity, s.color};
          const double before = left;
          double alpha = 0;
          const Step step = composite<double>(splat, x, y, left, alpha);
          if (step == Step::stops) break;
          double& most = largest[trace.gaussians[slot]];
          if (step == Step::blends) most = std::max(most, alpha * before);
        }
      }
    return largest;
  }

  const Camera camera_ = front_camera(kSide, kSide);
  const GaussianCloud cloud_ = random_cloud(3000, 0, 11);
  std::unique_ptr<Renderer> renderer_ = make_renderer(Backend::cpu, pool());
};

TEST_P(SelectedByShape, visible_gaussians_have_the_weight_at_a_pixel_of_the_shape) {
  const std::vector<glm::dvec2> stroke = {{10, 80}, {45, 20}, {89, 33}};
  for (const Shape& shape :
       {Shape::rectangle({20, 17}, {61, 40}), Shape::stroke(stroke, 3.5),
        Shape::rectangle({-100, -100}, {500, 500}), Shape::rectangle({44.5, 44.5}, {45.5, 45.5})}) {
    const std::vector<double> expected = weights(shape);
    for (const float weight : {0.0f, 0.01f, 0.05f, 0.5f}) {
      const GaussianSet seen = this->seen(default_mode(), shape, weight);
      std::size_t sure = 0;
      for (std::size_t i = 0; i < cloud_.size(); ++i) {
        if (std::abs(expected[i] - double{weight}) < kMargin || std::abs(expected[i]) < kMargin)
          continue;
        EXPECT_EQ(seen[i], expected[i] >= double{weight}) << i << ": " << expected[i];
        sure += seen[i];
      }
      EXPECT_TRUE(sure > 0 || weight > 0.1f);
      // Every mode that leaves out no pixel and every number of threads find the same.
      for (const CullMode mode : {find_culler("adr"), find_culler("exact")})
        EXPECT_EQ(this->seen(mode, shape, weight), seen);
    }
  }
}

TEST_P(SelectedByShape, gaussians_of_a_part_are_seen_as_in_a_cloud_of_the_part) {
  const GaussianSet odd =
      GaussianSet::where(cloud_.size(), pool(), [](std::size_t i) { return i % 2 == 1; });
  const Shape shape = Shape::rectangle({20, 17}, {61, 40});
  renderer_->upload(select(cloud_, odd.numbers()), {});
  const GaussianSet rest = seen(default_mode(), shape, 0.05f);
  renderer_->upload(GaussianCloud(cloud_), {});
  renderer_->set_drawn(odd);
  const GaussianSet found = seen(default_mode(), shape, 0.05f);
  EXPECT_EQ(found.count(), rest.count());
  for (std::size_t i = 0; i < rest.size(); ++i) EXPECT_EQ(found[2 * i + 1], rest[i]) << i;
}

TEST_P(SelectedByShape, a_share_is_the_weight_of_the_set_in_a_pixel) {
  const GaussianSet third =
      GaussianSet::where(cloud_.size(), pool(), [](std::size_t i) { return i % 3 == 0; });
  GaussianCloud white = cloud_;  // the others are black
  for (std::size_t i = 0; i < white.size(); ++i)
    white.sh[i] = glm::vec3((third[i] ? 0.5f : -0.5f) / static_cast<float>(kSh0));
  renderer_->upload(std::move(white), {});
  const Image expected = frame(default_mode(), {}).color;
  renderer_->upload(GaussianCloud(cloud_), {});
  const Image plain = frame(default_mode(), {}).color;
  Outputs outputs{.trace = true};
  outputs.share = std::make_shared<const GaussianSet>(third);
  const Frame& shared = frame(default_mode(), outputs);
  EXPECT_EQ(shared.color.values, plain.values) << "the picture stays";
  ASSERT_EQ(shared.share.size(), std::size_t{kSide} * kSide);
  for (std::size_t i = 0; i < shared.share.size(); ++i)
    EXPECT_NEAR(shared.share[i], expected.values[3 * i], 1e-5) << i;
  outputs.share = std::make_shared<const GaussianSet>(cloud_.size());
  const std::vector<float> none = frame(default_mode(), outputs).share;
  EXPECT_EQ(none, std::vector<float>(none.size()));
  EXPECT_TRUE(frame(default_mode(), {}).share.empty());
}

TEST(SelectedInPictures, tiles_of_other_sizes_and_pictures_of_any_size_are_selected_in) {
  const GaussianCloud cloud = random_cloud(500, 0, 3);
  const auto renderer = make_renderer(Backend::cpu, pool());
  renderer->upload(GaussianCloud(cloud), {});
  for (const glm::ivec2 size : {glm::ivec2(1, 1), {15, 16}, {17, 33}, {160, 5}}) {
    RenderSettings settings;
    GaussianSet usual;
    for (const int tile_px : {16, 8, 32}) {
      settings.tile_px = tile_px;
      Outputs outputs{.color = false};
      outputs.seen = pixels_in(Shape::rectangle({-9, -9}, {999, 999}), size, 0.02f, pool());
      outputs.share = std::make_shared<const GaussianSet>(GaussianSet(cloud.size()).complement());
      const Frame& frame = renderer->render(front_camera(size.x, size.y), settings, outputs);
      if (tile_px == 16) usual = frame.seen;
      EXPECT_EQ(frame.seen, usual);
      EXPECT_GT(frame.seen.count(), 0u);
      for (const float share : frame.share) EXPECT_TRUE(share >= 0 && share <= 1) << share;
    }
    Outputs nothing{.color = false};
    nothing.seen = pixels_in(Shape::rectangle({-9, -9}, {-5, -5}), size, 0, pool());
    EXPECT_TRUE(renderer->render(front_camera(size.x, size.y), {}, nothing).seen.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(Pipelines, SelectedByShape,
                         testing::Values(Pipeline::fast, Pipeline::classic), [](const auto& test) {
                           return kPipelineNames[static_cast<int>(test.param)];
                         });

TEST(SelectedThrough, gaussians_have_centres_in_front_and_in_the_shape) {
  const GaussianCloud cloud = surrounding_cloud(5000, 0, 4);
  Camera camera = front_camera(kSide, kSide);
  const Shape shape = Shape::rectangle({20, 17}, {61, 40});
  const GaussianSet found = gaussians_through(cloud, camera, shape, pool());
  EXPECT_EQ(found, gaussians_through(cloud, camera, shape, pool(1)));
  std::size_t count = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 p = cloud.positions[i];
    const double x = p.x / p.z * camera.focal_px.x + camera.center_px.x;
    const double y = p.y / p.z * camera.focal_px.y + camera.center_px.y;
    const bool inside = p.z > camera.near_depth && x >= 20 && x < 61 && y >= 17 && y < 40;
    EXPECT_EQ(found[i], inside) << i;
    count += inside;
  }
  EXPECT_GT(count, 20u);
  // A cloud and its camera that count from elsewhere.
  GaussianCloud moved = cloud;
  camera.origin = moved.origin = {1000, 2000, -500};
  EXPECT_EQ(gaussians_through(moved, camera, shape, pool()), found);
  camera.origin = {1000, 2000, -501};
  EXPECT_NE(gaussians_through(moved, camera, shape, pool()), found);
}

}  // namespace
}  // namespace qs::test
