// SPDX-License-Identifier: MIT
// The scene in the fast CPU pipeline: its order, its blocks, and that frames skip only blocks that
// the view cannot show.
#include <algorithm>
#include <numeric>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "raster/cpu/classic/classic.h"
#include "raster/cpu/fast/pipeline.h"
#include "raster/scene/cloud_order.h"
#include "support/scenes.h"

namespace qs {
namespace {

using cpu::fast::kBlock;

/// A scene in the pipeline's layout, and views of it.
struct Subject {
  explicit Subject(GaussianCloud of)
      : cloud(std::move(of)), scene(cpu::fast::make_scene(cloud, pool)) {}

  cpu::FrameContext frame(const Camera& camera, const RenderSettings& settings) {
    return {cloud, camera, settings, TileGrid::of_image(camera.width, camera.height), pool, {}};
  }

  std::vector<bool> missed(const Camera& camera, const RenderSettings& settings) {
    const cpu::FrameContext context = frame(camera, settings);
    const View<float> view = make_view<float>(camera);
    const Frustum frustum(view, context.rules(), context.grid);
    std::vector<bool> missed;
    for (const BlockBounds& bounds : scene.bounds) missed.push_back(frustum.misses(bounds));
    return missed;
  }

  ThreadPool pool{2};
  GaussianCloud cloud;
  cpu::fast::SceneBlocks scene;
};

/// A camera in the centre of surrounding_cloud() that looks in direction number `way`.
Camera inside(int way, double vertical_fov = 0.6) {
  const glm::dvec3 ways[] = {{1, 0, 0},    {-1, 0.1, 0}, {0, 1, 0},
                             {0.1, -1, 0}, {0, 0.1, 1},  {0, 0, -1}};
  return look_at({0, 0, 0}, ways[way], {0.3, 0.2, 0.9}, vertical_fov, 160, 120);
}

TEST(SpatialOrder, has_every_gaussian_once_and_equal_ones_in_the_order_of_the_file) {
  GaussianCloud cloud = test::surrounding_cloud(5000, 0, 1);
  for (std::size_t i = 4000; i < 5000; ++i) {
    cloud.positions[i] = cloud.positions[17];
    cloud.log_scales[i] = cloud.log_scales[17];
  }
  ThreadPool pool(3);
  const auto order = spatial_order(cloud, pool);
  std::vector<std::uint32_t> sorted(order.begin(), order.end()), all(cloud.size());
  std::sort(sorted.begin(), sorted.end());
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(sorted, all);
  std::uint32_t last = 17;
  for (const std::uint32_t i : order) {
    if (i < 4000) continue;
    EXPECT_GT(i, last);
    last = i;
  }
  EXPECT_TRUE(spatial_order(GaussianCloud(), pool).empty());
}

TEST(SpatialOrder, makes_blocks_compact_also_when_a_few_gaussians_are_far_away) {
  GaussianCloud cloud = test::surrounding_cloud(40000, 0, 2);
  for (std::size_t i = 0; i < 40; ++i) cloud.positions[i * 1000] *= 1e4f;
  Subject subject(std::move(cloud));
  std::vector<float> sizes;
  for (const BlockBounds& bounds : subject.scene.bounds) {
    const glm::vec3 size = bounds.high - bounds.low;
    sizes.push_back(std::max({size.x, size.y, size.z}));
  }
  std::nth_element(sizes.begin(), sizes.begin() + 80, sizes.end());
  EXPECT_LT(sizes[80], 10.0f);  // the scene without them is about 100 wide
}

TEST(SpatialOrder, large_gaussians_are_in_few_blocks) {
  GaussianCloud cloud = test::surrounding_cloud(40000, 0, 2);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.log_scales[i] = glm::vec3(i % 100 == 0 ? std::log(3.0f) : std::log(1.0f));
  const Subject small(cloud);
  for (std::size_t i = 0; i < cloud.size(); i += 100)
    cloud.log_scales[i] = glm::vec3(std::log(9.0f));
  const Subject large(std::move(cloud));
  const auto blocks_above = [](const Subject& subject, float sigma) {
    return std::count_if(subject.scene.bounds.begin(), subject.scene.bounds.end(),
                         [=](const BlockBounds& bounds) { return bounds.sigma > sigma; });
  };
  // 400 of them fill two blocks, and may begin inside another block.
  EXPECT_LE(blocks_above(small, 2), 3);
  EXPECT_LE(blocks_above(large, 2), 3);
}

TEST(BlockBounds, hold_every_member) {
  const Subject subject(test::surrounding_cloud(3000, 0, 3));
  std::size_t members = 0;
  for (std::size_t b = 0; b < subject.scene.blocks.size(); ++b) {
    const cpu::fast::Block& block = subject.scene.blocks[b];
    const BlockBounds& bounds = subject.scene.bounds[b];
    for (std::size_t lane = 0; lane < kBlock && members < subject.cloud.size(); ++lane, ++members) {
      const std::uint32_t i = block.gaussian[lane];
      const glm::vec3 p = subject.cloud.positions[i], s = subject.cloud.log_scales[i];
      EXPECT_EQ(glm::vec3(block.x[lane], block.y[lane], block.z[lane]), p);
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LE(bounds.low[axis], p[axis]);
        EXPECT_GE(bounds.high[axis], p[axis]);
      }
      EXPECT_GE(bounds.sigma * 1.00001f, std::exp(std::max({s.x, s.y, s.z})));
    }
  }
  EXPECT_EQ(members, subject.cloud.size());
}

class FrustumOf : public testing::TestWithParam<Projection> {};

INSTANTIATE_TEST_SUITE_P(Projections, FrustumOf,
                         testing::Values(Projection::pinhole, Projection::face,
                                         Projection::orthographic));

TEST_P(FrustumOf, misses_no_block_with_a_gaussian_that_some_mode_lists) {
  GaussianCloud cloud = test::surrounding_cloud(20000, 0, 4);
  for (std::size_t i = 0; i < 5; ++i) cloud.log_scales[i * 3000] += 5.0f;
  Subject subject(std::move(cloud));
  const ActivatedCloud active = activate(subject.cloud, subject.pool);
  std::ptrdiff_t all_missed = 0;
  for (const double fov : {0.05, 0.6, 2.5}) {
    for (int way = 0; way < 6; ++way) {
      for (const float scale : {0.1f, 1.0f, 20.0f}) {
        for (CullMode mode = 1; mode <= mode_count(); ++mode) {
          const Camera camera = test::with_projection(inside(way, fov), GetParam(), 20);
          RenderSettings settings;
          settings.mode = mode;
          settings.splat_scale = scale;
          settings.dilation = way % 2 == 0 ? 0.3 : 0.01;
          const std::vector<bool> missed = subject.missed(camera, settings);
          all_missed += std::count(missed.begin(), missed.end(), true);
          const cpu::FrameContext frame = subject.frame(camera, settings);
          cpu::Visible visible;
          cpu::preprocess(frame, active, visible);
          std::vector<bool> shown(subject.cloud.size());
          visible.for_each([&](std::uint32_t slot) { shown[visible.gaussians[slot]] = true; });
          for (std::size_t b = 0; b < missed.size(); ++b) {
            if (!missed[b]) continue;
            for (std::size_t lane = 0; lane < kBlock && b * kBlock + lane < shown.size(); ++lane)
              ASSERT_FALSE(shown[subject.scene.blocks[b].gaussian[lane]]) << b;
          }
        }
      }
    }
  }
  EXPECT_GT(all_missed, 1000);
}

/// A thin Gaussian of 200 px standard deviation, beyond side 0..3 (left, right, top, bottom) of the
/// image by `share` of its reach. It is at a right angle to the side, and the other focal length is
/// small, so that the frustum's bound of the reach is only a little larger than the reach.
std::pair<GaussianCloud, Camera> beyond_the_border(int side, double share) {
  const int along = side / 2, across = 1 - along;
  glm::ivec2 size(16);
  size[along] = 2000;
  Camera camera;
  camera.width = size.x;
  camera.height = size.y;
  camera.focal_px[along] = 5000;
  camera.focal_px[across] = 50;
  camera.center_px = 0.5 * glm::dvec2(size - 1);
  constexpr double kSigmaPx = 200, kDepth = 3;
  const double reach = std::sqrt(2 * std::log(255.0)) * kSigmaPx;
  const double from_center = 0.5 * size[along] + share * reach;  // px
  glm::vec3 position(0, 0, kDepth);
  position[along] = static_cast<float>((side % 2 == 0 ? -1 : 1) * from_center / 5000 * kDepth);
  GaussianCloud cloud = test::single_gaussian(position, 1, {1, 1, 1}, INFINITY);
  cloud.log_scales[0] = glm::vec3(-INFINITY);
  cloud.log_scales[0][along] = static_cast<float>(std::log(kSigmaPx / 5000 * kDepth));
  return {cloud, camera};
}

TEST(Frustum, keeps_gaussians_beyond_every_border_that_still_reach_the_picture) {
  for (int side = 0; side < 4; ++side) {
    for (const double share : {0.5, 0.8, 0.9, 0.97, 3.0}) {
      SCOPED_TRACE(testing::Message() << "side " << side << ", " << share << " of the reach");
      const auto [cloud, camera] = beyond_the_border(side, share);
      Subject subject(cloud);
      RenderSettings settings;
      for (const char* mode : {"adr", "quadbox", "exact"}) {
        settings.mode = find_culler(mode);
        const cpu::FrameContext frame = subject.frame(camera, settings);
        cpu::Visible classic;
        cpu::preprocess(frame, activate(subject.cloud, subject.pool), classic);
        ASSERT_EQ(classic.count, share < 1 ? 1u : 0u) << mode;
        cpu::fast::FastVisible fast;
        cpu::fast::preprocess(frame, subject.scene, false, fast);
        EXPECT_EQ(fast.count, classic.count) << mode;
      }
      EXPECT_EQ(subject.missed(camera, settings).front(), share > 1);
    }
  }
}

TEST(Frustum, misses_most_of_a_scene_around_the_camera_and_nothing_of_one_in_front) {
  GaussianCloud cloud = test::surrounding_cloud(60000, 0, 5);
  for (glm::vec3& position : cloud.positions) position += 10.0f * glm::normalize(position);
  Subject around(std::move(cloud));
  RenderSettings settings;
  // as small in relation to the scene as the Gaussians of trained scenes
  settings.splat_scale = 0.1f;
  for (int way = 0; way < 6; ++way) {
    const std::vector<bool> missed = around.missed(inside(way), settings);
    EXPECT_GT(std::count(missed.begin(), missed.end(), true), std::ssize(missed) / 2) << way;
  }
  const std::vector<bool> missed =
      around.missed(look_at({0, 0, -200}, {0, 0, 0}, {0, 1, 0}, 0.6, 160, 120), {});
  EXPECT_EQ(std::count(missed.begin(), missed.end(), true), 0);
}

TEST(Preprocess, does_not_read_blocks_that_the_view_misses) {
  Subject subject(test::surrounding_cloud(20000, 1, 6));
  const Camera camera = inside(4);
  const RenderSettings settings;
  const cpu::FrameContext frame = subject.frame(camera, settings);
  cpu::fast::FastVisible expected, got;
  cpu::fast::preprocess(frame, subject.scene, false, expected);
  ASSERT_GT(expected.count, 100u);

  // Moves the Gaussians of missed blocks to visible positions.
  const std::vector<bool> missed = subject.missed(camera, settings);
  ASSERT_GT(std::count(missed.begin(), missed.end(), true), 20);
  for (std::size_t b = 0; b < missed.size(); ++b) {
    cpu::fast::Block& block = subject.scene.blocks[b];
    if (!missed[b]) continue;
    std::fill_n(block.x, kBlock, 0.0f);
    std::fill_n(block.y, kBlock, 0.3f);
    std::fill_n(block.z, kBlock, 3.0f);
  }
  cpu::fast::preprocess(frame, subject.scene, false, got);
  EXPECT_EQ(got.count, expected.count);
  const auto gaussians_of = [](const cpu::VisibleSlots& visible) {
    std::vector<std::uint32_t> gaussians;
    visible.for_each([&](std::uint32_t slot) { gaussians.push_back(visible.gaussians[slot]); });
    return gaussians;
  };
  EXPECT_EQ(gaussians_of(got), gaussians_of(expected));
}

}  // namespace
}  // namespace qs
