// SPDX-License-Identifier: MIT
//
// The fp64 reference: the pixels that it considers for a Gaussian, and regions inside, across and
// outside of the picture.
#include "raster/cpu/common/reference.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "raster/api/renderer.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

struct Box {
  int x0, y0, x1, y1;
};

class ReferenceMode : public testing::Test {
 protected:
  const Frame& draw(const GaussianCloud& cloud, const Camera& camera,
                    std::optional<PixelBox> region = {}) {
    renderer_ = make_renderer(Backend::cpu, test::pool(2));
    renderer_->upload(cloud, {});
    return again(camera, region);
  }
  const Frame& again(const Camera& camera, std::optional<PixelBox> region = {}) {
    RenderSettings settings;
    settings.mode = kReferenceMode;
    settings.background = {0.25f, 0.5f, 1};
    Outputs outputs;
    outputs.evaluated = true;
    outputs.trace = true;
    outputs.region = region;
    return renderer_->render(camera, settings, outputs);
  }

 private:
  std::unique_ptr<Renderer> renderer_;
};

TEST_F(ReferenceMode, considers_the_pixels_of_the_box_at_alpha_1_255_and_one_more_on_each_side) {
  const Camera camera = test::front_camera(90, 50);
  for (const glm::vec3 at :
       {glm::vec3(0.1f, -0.2f, 3), {1.5f, 0, 3}, {-1.7f, 0.9f, 3}, {0, 0, 2.5f}}) {
    for (const float logit : {-4.0f, 0.0f, 4.0f}) {
      SCOPED_TRACE(testing::Message() << at.x << " " << at.y << " " << logit);
      const Frame& frame = draw(test::single_gaussian(at, 0.1f, {1, 0.5f, 0}, logit), camera);
      ASSERT_EQ(frame.trace.footprints.size(), frame.stats.visible);
      // The projected covariance with its dilation, from the definition.
      const double opacity = 1 / (1 + std::exp(-static_cast<double>(logit)));
      const double reach = std::sqrt(2 * std::log(255 * opacity));
      const glm::dvec2 focal = camera.focal_px, slope(at.x / at.z, at.y / at.z);
      const glm::dvec2 mean = camera.center_px + focal * slope;
      const double sigma2 = 0.01 / (static_cast<double>(at.z) * static_cast<double>(at.z));
      const auto half = [&](int axis) {
        return reach *
               std::sqrt(focal[axis] * focal[axis] * sigma2 * (1 + slope[axis] * slope[axis]) +
                         0.3);
      };
      const auto range = [](double low, double high, int size) {
        const int begin = std::clamp(static_cast<int>(std::floor(low)) - 1, 0, size);
        return std::pair(begin, std::clamp(static_cast<int>(std::ceil(high)) + 2, 0, size));
      };
      const auto [x0, x1] = range(mean.x - half(0), mean.x + half(0), 90);
      const auto [y0, y1] = range(mean.y - half(1), mean.y + half(1), 50);
      for (int y = 0; y < 50; ++y) {
        for (int x = 0; x < 90; ++x) {
          const bool inside = x >= x0 && x < x1 && y >= y0 && y < y1;
          ASSERT_EQ(frame.evaluated[static_cast<std::size_t>(y * 90 + x)], inside ? 1u : 0u)
              << x << " " << y;
        }
      }
      EXPECT_EQ(frame.stats.visible, x0 < x1 && y0 < y1 ? 1u : 0u);
    }
  }
}

TEST_F(ReferenceMode, regions_are_cut_to_the_picture_and_the_rest_is_cleared) {
  const Camera camera = test::front_camera(70, 40);
  const GaussianCloud cloud = test::random_cloud(300, 1, 4);
  const Image whole = draw(cloud, camera).color;
  const std::pair<PixelBox, Box> regions[] = {
      {{10, 5, 33, 29}, {10, 5, 33, 29}},   {{-9, -3, 20, 11}, {0, 0, 20, 11}},
      {{60, 30, 99, 99}, {60, 30, 70, 40}}, {{0, 0, 70, 40}, {0, 0, 70, 40}},
      {{30, 20, 10, 10}, {30, 20, 30, 20}}, {{80, 50, 90, 60}, {70, 40, 70, 40}},
      {{69, 39, 70, 40}, {69, 39, 70, 40}}};
  for (const auto& [asked, drawn] : regions) {
    SCOPED_TRACE(testing::Message()
                 << asked.x0 << " " << asked.y0 << " " << asked.x1 << " " << asked.y1);
    const Frame& frame = again(camera, asked);
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 70; ++x) {
        const bool inside = x >= drawn.x0 && x < drawn.x1 && y >= drawn.y0 && y < drawn.y1;
        for (int c = 0; c < 3; ++c)
          ASSERT_EQ(frame.color.at(x, y, c), inside ? whole.at(x, y, c) : 0) << x << " " << y;
      }
    }
  }
}

TEST_F(ReferenceMode, its_trace_lists_all_gaussians_of_one_tile_by_depth_and_index) {
  GaussianCloud cloud = test::single_gaussian({0, 0, 5}, 0.2f, {1, 0, 0}, 2);
  for (const float z : {3.0f, 5.0f, 4.0f, 3.0f})
    test::append(cloud, test::single_gaussian({0, 0, z}, 0.2f, {0, 1, 0}, 2));
  test::append(cloud, test::single_gaussian({0, 0, -3}, 0.2f, {0, 1, 0}, 2));
  const Frame& frame = draw(cloud, test::front_camera(40, 30));
  EXPECT_EQ(std::vector<std::uint32_t>(frame.trace.listed.begin(), frame.trace.listed.end()),
            (std::vector<std::uint32_t>{1, 4, 3, 0, 2}));
  EXPECT_EQ(
      std::vector<std::uint64_t>(frame.trace.tile_begin.begin(), frame.trace.tile_begin.end()),
      (std::vector<std::uint64_t>{0, 5}));
  EXPECT_EQ(std::vector<std::uint32_t>(frame.trace.gaussians.begin(), frame.trace.gaussians.end()),
            (std::vector<std::uint32_t>{0, 1, 2, 3, 4}));
  const float depths[] = {5, 3, 5, 4, 3};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(frame.trace.depths[i], depths[i]);
    EXPECT_NEAR(frame.trace.footprints[i].gamma, 2 * std::log(255 / (1 + std::exp(-2.0))), 1e-5);
    EXPECT_NEAR(frame.trace.footprints[i].conic.x * frame.trace.footprints[i].covariance.xx, 1,
                1e-3);
    EXPECT_NEAR(frame.trace.footprints[i].determinant,
                frame.trace.footprints[i].covariance.xx * frame.trace.footprints[i].covariance.yy,
                1e-2);
  }
}

}  // namespace
}  // namespace qs
