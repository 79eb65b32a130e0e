// SPDX-License-Identifier: MIT
//
// Gaussians under a shape, against the weights of a frame in double precision.
#include "raster/select/by_shape.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "raster/kernel/composite.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs::test {
namespace {

constexpr int kSide = 90;
constexpr double kMargin = 1e-4;  // of weights

class SelectedByShape : public testing::TestWithParam<Pipeline> {
 protected:
  SelectedByShape() { renderer_->upload(GaussianCloud(cloud_), {}); }

  const Frame& frame(CullMode mode) {
    RenderSettings settings;
    settings.mode = mode;
    settings.pipeline = GetParam();
    return renderer_->render(camera_, settings, {.color = false, .trace = true});
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
      const GaussianSet seen =
          gaussians_seen(frame(default_mode()), {kSide, kSide}, shape, weight, pool());
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
        EXPECT_EQ(gaussians_seen(frame(mode), {kSide, kSide}, shape, weight, pool(1)), seen);
    }
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
