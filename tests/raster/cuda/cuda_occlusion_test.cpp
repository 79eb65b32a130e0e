// SPDX-License-Identifier: MIT
// Frames drawn in slabs of depth, which leave out hidden Gaussians, equal frames that list all.
#include <cmath>
#include <cstdlib>

#include "raster/kernel/cull/table.h"
#include "support/gpu.h"
#include "support/scenes.h"

namespace qs {
namespace {

constexpr int kPicture = 96;  // px

class CudaOcclusion : public test::GpuTest {
 protected:
  /// A renderer that draws every frame with RenderSettings::occlusion in so many slabs.
  static std::unique_ptr<Renderer> renderer_in(unsigned slabs, const GaussianCloud& cloud) {
    setenv("QUADSPLAT_SLABS", std::to_string(slabs).c_str(), 1);
    auto renderer = renderer_of(Backend::cuda, cloud);
    unsetenv("QUADSPLAT_SLABS");
    return renderer;
  }

  static RenderSettings settings_with(bool occlusion, const char* mode = "exact") {
    RenderSettings settings;
    settings.mode = find_culler(mode);
    settings.background = {0.25f, 0.5f, 1};
    settings.occlusion = occlusion;
    return settings;
  }
};

struct OccludedView {
  const char* name;
  GaussianCloud cloud;
  Camera camera;
  bool hides;  // a part of the Gaussians
};

GaussianCloud scattered(std::size_t count) {
  return test::scattered_cloud(count, kPicture,
                               [](std::size_t i) { return 2 + 1e-3 * double(i * 7919 % 9973); });
}

/// Opaque layers at a distance, which cover the picture but for a hole of `hole` px.
GaussianCloud with_wall(GaussianCloud cloud, float distance, int hole) {
  const Camera camera = test::front_camera(kPicture, kPicture);
  const auto px = static_cast<double>(distance) / camera.focal_px.x;
  for (int layer = 0; layer < 4; ++layer)
    for (int y = 0; y < kPicture; y += 2)
      for (int x = 0; x < kPicture; x += 2) {
        if (std::abs(x - kPicture / 2) < hole && std::abs(y - kPicture / 2) < hole) continue;
        const glm::vec3 position((x - camera.center_px.x) * px, (y - camera.center_px.y) * px,
                                 distance);
        const auto sigma = static_cast<float>(2 * px);
        test::append(cloud, test::single_gaussian(position, sigma, {1, 0.5f, 0}, 9));
      }
  return cloud;
}

std::vector<OccludedView> occluded_views() {
  const Camera camera = test::front_camera(kPicture, kPicture);
  Camera inside = camera;  // between two opaque layers of Gaussians
  inside.near_depth = 0.01;
  GaussianCloud flat = test::scattered_cloud(1500, kPicture, [](std::size_t) { return 3.0; });
  return {
      {"nothing in front", scattered(1500), camera, false},
      {"a wall", with_wall(scattered(1500), 1.9f, 0), camera, true},
      {"a wall with a hole", with_wall(scattered(1500), 1.9f, 3), camera, true},
      {"a wall in the middle", with_wall(scattered(1500), 6, 0), camera, true},
      {"a camera inside", with_wall(test::surrounding_cloud(1500, 0, 3), 0.5f, 0), inside, true},
      {"equal depths", with_wall(flat, 2.9f, 0), camera, true},
      {"equal depths alone", flat, camera, false},
      {"one Gaussian", test::single_gaussian({0, 0, 3}, 0.1f, {1, 1, 1}, 9), camera, false},
      {"no Gaussian", GaussianCloud{}, camera, false}};
}

TEST_F(CudaOcclusion, leaves_the_picture_as_it_is) {
  for (const OccludedView& c : occluded_views())
    for (const unsigned slabs : {2u, 5u, 16u}) {
      SCOPED_TRACE(testing::Message() << c.name << " in " << slabs << " slabs");
      const auto gpu = renderer_in(slabs, c.cloud);
      const Frame off = gpu->render(c.camera, settings_with(false));
      EXPECT_FALSE(off.stats.is_occluded);
      EXPECT_EQ(off.stats.listed, off.stats.tile_pairs);
      const Frame on = gpu->render(c.camera, settings_with(true));
      EXPECT_TRUE(on.stats.is_occluded);
      EXPECT_EQ(on.color.values, off.color.values);
      EXPECT_LE(on.stats.listed, off.stats.listed);
      EXPECT_EQ(on.stats.listed < off.stats.listed, c.hides);
    }
}

TEST_F(CudaOcclusion, leaves_lossless_modes_equal_bit_for_bit) {
  const GaussianCloud cloud = with_wall(scattered(1500), 4, 5);
  const auto gpu = renderer_in(4, cloud);
  const Camera camera = test::front_camera(kPicture, kPicture);
  const Frame first = gpu->render(camera, settings_with(true));
  for (const CullMode mode : test::tiled_modes()) {
    if (!row_of(mode).lossless) continue;
    SCOPED_TRACE(mode_name(mode));
    EXPECT_EQ(gpu->render(camera, settings_with(true, mode_name(mode))).color.values,
              first.color.values);
  }
}

TEST_F(CudaOcclusion, draws_long_lists_within_rounding) {
  const GaussianCloud cloud = test::scattered_cloud(
      40'000, 32, [](std::size_t i) { return 2 + 1e-4 * double(i * 7919 % 9973); });
  const Camera camera = test::front_camera(32, 32);
  const auto gpu = renderer_in(3, cloud);
  const Frame off = gpu->render(camera, settings_with(false));
  const Frame on = gpu->render(camera, settings_with(true));
  EXPECT_LT(on.stats.listed, off.stats.listed);
  EXPECT_GE(psnr_8bit(on.color, off.color), 100.0);
  EXPECT_LE(test::share_beyond(on.color, off.color, 1e-5), 0.0);
}

TEST_F(CudaOcclusion, counts_the_pairs_of_the_mode_on_request) {
  const GaussianCloud cloud = with_wall(scattered(1500), 1.9f, 0);
  const Camera camera = test::front_camera(kPicture, kPicture);
  const auto gpu = renderer_in(4, cloud);
  const RenderStats off = gpu->render(camera, settings_with(false)).stats;
  const RenderStats plain = gpu->render(camera, settings_with(true)).stats;
  EXPECT_EQ(plain.tile_pairs, 0u);
  EXPECT_EQ(plain.visible, 0u);
  Outputs counted;
  counted.mode_pairs = true;
  const RenderStats on = gpu->render(camera, settings_with(true), counted).stats;
  EXPECT_EQ(on.tile_pairs, off.tile_pairs);
  EXPECT_EQ(on.visible, off.visible);
  EXPECT_LT(on.listed, off.listed);
}

TEST_F(CudaOcclusion, leaves_out_nothing_where_maps_or_lists_are_requested) {
  const auto gpu = renderer_in(4, with_wall(scattered(1500), 1.9f, 0));
  const Camera camera = test::front_camera(kPicture, kPicture);
  for (bool Outputs::*const output : {&Outputs::pairs, &Outputs::evaluated, &Outputs::used,
                                      &Outputs::depth, &Outputs::trace, &Outputs::stage_times}) {
    Outputs outputs;
    outputs.*output = true;
    EXPECT_FALSE(gpu->render(camera, settings_with(true), outputs).stats.is_occluded);
  }
}

TEST_F(CudaOcclusion, is_for_views_of_millions) {
  const auto gpu = renderer_of(Backend::cuda, scattered(1500));
  const Camera camera = test::front_camera(kPicture, kPicture);
  EXPECT_FALSE(gpu->render(camera, settings_with(true)).stats.is_occluded);
}

TEST_F(CudaOcclusion, draws_a_thousand_random_clouds_as_they_are) {
  const unsigned count = test::gpu_is_emulated() ? 12 : 1000;
  for (unsigned seed = 0; seed < count; ++seed) {
    SCOPED_TRACE(seed);
    GaussianCloud cloud = test::random_cloud(600, 0, seed);
    if (seed % 2 == 1)
      cloud = with_wall(std::move(cloud), 1 + 0.5f * float(seed % 13), int(seed % 7));
    const auto gpu = renderer_in(2 + seed % 9, cloud);
    const Camera camera = test::front_camera(kPicture, 16 + int(seed % kPicture));
    const Frame off = gpu->render(camera, settings_with(false));
    ASSERT_EQ(gpu->render(camera, settings_with(true)).color.values, off.color.values);
  }
}

}  // namespace
}  // namespace qs
