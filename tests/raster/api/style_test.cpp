// SPDX-License-Identifier: MIT
// The styles points and ellipsoids: their shapes, and equal pictures in all modes, pipelines and
// the reference.
#include <cmath>

#include "support/depth_maps.h"
#include "support/gpu.h"
#include "support/mode_pairs.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

RenderSettings drawn_as(DrawStyle style, const char* mode = "quadbox") {
  RenderSettings settings;
  settings.style = style;
  settings.mode = find_culler(mode);
  return settings;
}

Frame picture_of(const GaussianCloud& cloud, const Camera& camera, const RenderSettings& settings,
                 const Outputs& outputs = {}) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(cloud, {});
  return renderer->render(camera, settings, outputs);
}

/// The alpha of every pixel is `alpha` inside of `inner` and 0 outside of `outer`, distances from
/// the picture's middle in units of `half_axes`. Some pixels must be inside.
void expect_solid(const Image& white, glm::dvec2 half_axes, double inner = 0.98,
                  double outer = 1.08) {
  const glm::dvec2 middle = 0.5 * glm::dvec2(white.width - 1, white.height - 1);
  int inside = 0;
  for (int y = 0; y < white.height; ++y) {
    for (int x = 0; x < white.width; ++x) {
      const double distance = glm::length((glm::dvec2(x, y) - middle) / half_axes);
      if (distance < inner) {
        EXPECT_NEAR(white.at(x, y, 0), 0.99, 1e-6) << x << " " << y;
        ++inside;
      }
      if (distance > outer) {
        EXPECT_EQ(white.at(x, y, 0), 0) << x << " " << y;
      }
    }
  }
  EXPECT_GT(inside, 0);
}

constexpr const char* kSomeModes[] = {"reference", "3dgs", "adr", "quadbox", "exact", "accutile"};

class SolidStyle : public testing::TestWithParam<DrawStyle> {};

INSTANTIATE_TEST_SUITE_P(Styles, SolidStyle,
                         testing::Values(DrawStyle::points, DrawStyle::ellipsoids),
                         [](const auto& style) {
                           return std::string(kDrawStyleNames[static_cast<int>(style.param)]);
                         });

TEST_P(SolidStyle, is_equal_bit_for_bit_in_lossless_modes_and_the_same_picture_in_3dgs) {
  const GaussianCloud cloud = test::random_cloud(4000, 1, 77);
  const Camera camera = test::front_camera(320, 200);
  for (const Pipeline pipeline : {Pipeline::fast, Pipeline::classic}) {
    RenderSettings settings = drawn_as(GetParam(), "adr");
    settings.pipeline = pipeline;
    const Frame adr = picture_of(cloud, camera, settings);
    EXPECT_GT(adr.stats.visible, 100u);
    for (const char* name : {"quadbox-naive", "quadbox", "exact"}) {
      settings.mode = find_culler(name);
      EXPECT_EQ(picture_of(cloud, camera, settings).color.values, adr.color.values) << name;
    }
    settings.mode = find_culler("3dgs");
    test::expect_same_image(picture_of(cloud, camera, settings).color, adr.color);
  }
}

TEST_P(SolidStyle, is_that_of_the_reference) {
  const Camera camera = test::front_camera(161, 117);
  RenderSettings other = drawn_as(GetParam());
  other.background = {0.2f, 0.4f, 0.9f};
  other.splat_scale = 0.7f;
  other.dilation = 0.3 / 4;
  other.sh_degree = 0;
  Outputs outputs;
  outputs.depth = true;
  for (const unsigned seed : {11u, 12u}) {
    const GaussianCloud cloud = test::random_cloud(4000, 1, seed);
    for (RenderSettings settings : {drawn_as(GetParam()), other}) {
      settings.mode = kReferenceMode;
      const Frame expected = picture_of(cloud, camera, settings, outputs);
      for (const char* mode : {"3dgs", "quadbox"}) {
        for (const Pipeline pipeline : {Pipeline::fast, Pipeline::classic}) {
          SCOPED_TRACE(testing::Message() << mode << " " << seed);
          settings.mode = find_culler(mode);
          settings.pipeline = pipeline;
          const Frame frame = picture_of(cloud, camera, settings, outputs);
          EXPECT_GE(psnr_8bit(frame.color, expected.color), 60.0);
          EXPECT_LE(test::share_beyond(frame.color, expected.color, 1.5 / 255), 1e-3);
          // At the steep edges rounding errors of means show.
          const DepthMaps &maps = frame.depth, &others = expected.depth;
          EXPECT_LE(test::share_beyond(maps.alpha, others.alpha, 0.005), 1e-3);
          EXPECT_LE(test::share_beyond(maps.expected, others.expected, 0.005), 1e-3);
          EXPECT_LE(test::share_beyond(maps.median, others.median, 1e-4), 1e-3);
        }
      }
    }
  }
}

TEST_P(SolidStyle, has_the_pairs_of_every_mode_s_own_frame) {
  for (const test::CountedScene& scene : test::counted_scenes(2000)) {
    if (scene.settings.dilation == 0) continue;
    SCOPED_TRACE(scene.name);
    const auto renderer = make_renderer(Backend::cpu, test::pool(2));
    renderer->upload(scene.cloud, {});
    RenderSettings settings = scene.settings;
    settings.style = GetParam();
    for (const Pipeline pipeline : {Pipeline::fast, Pipeline::classic}) {
      settings.pipeline = pipeline;
      test::expect_own_statistics(*renderer, *renderer, scene.camera, settings);
    }
  }
}

TEST_P(SolidStyle, does_not_depend_on_opacity_unless_it_is_too_faint_to_be_seen) {
  const Camera camera = test::front_camera(41, 41);
  const auto drawn = [&](float logit, const char* mode) {
    return picture_of(test::single_gaussian({0, 0, 3}, 0.2f, {1, 1, 1}, logit), camera,
                      drawn_as(GetParam(), mode))
        .color.values;
  };
  const float least = GetParam() == DrawStyle::points ? -std::log(254.0f) : -std::log(4.0f);
  for (const char* mode : kSomeModes) {
    SCOPED_TRACE(mode);
    const std::vector<float> opaque = drawn(INFINITY, mode);
    EXPECT_GT(opaque[3 * (20 * 41 + 20)], 0.98f);
    for (const float logit : {least + 1e-4f, 0.0f, 8.0f})
      EXPECT_EQ(drawn(logit, mode), opaque) << logit;
    for (const float logit : {least - 1e-4f, -8.0f, -INFINITY})
      EXPECT_EQ(drawn(logit, mode), std::vector<float>(opaque.size())) << logit;
  }
}

TEST_P(SolidStyle, ignores_antialiasing) {
  const GaussianCloud cloud = test::random_cloud(1000, 0, 5);
  const Camera camera = test::front_camera(90, 60);
  for (const char* mode : {"reference", "quadbox"}) {
    RenderSettings settings = drawn_as(GetParam(), mode);
    const Image plain = picture_of(cloud, camera, settings).color;
    settings.antialiased = true;
    EXPECT_EQ(picture_of(cloud, camera, settings).color.values, plain.values) << mode;
  }
}

TEST_P(SolidStyle, stops_a_pixel_at_the_second_layer_everywhere) {
  GaussianCloud cloud = test::single_gaussian({0, 0, 3}, 1, {1, 0, 0}, 0);
  test::append(cloud, test::single_gaussian({0, 0, 4}, 1, {0, 1, 0}, 0));
  const Camera camera = test::front_camera(41, 41);
  RenderSettings settings = drawn_as(GetParam());
  settings.background = {0, 0, 1};
  Outputs outputs;
  outputs.evaluated = true;
  for (const char* mode : {"reference", "quadbox"}) {
    for (const Pipeline pipeline : {Pipeline::fast, Pipeline::classic}) {
      settings.mode = find_culler(mode);
      settings.pipeline = pipeline;
      const Frame frame = picture_of(cloud, camera, settings, outputs);
      EXPECT_NEAR(frame.color.at(20, 20, 0), 0.99, 1e-6) << mode;
      EXPECT_NEAR(frame.color.at(20, 20, 1), 0, 1e-6) << mode;
      EXPECT_NEAR(frame.color.at(20, 20, 2), 0.01, 1e-6) << mode;
      EXPECT_EQ(frame.evaluated[20 * 41 + 20], 2u) << mode;
    }
  }
}

TEST(Ellipsoids, are_opaque_up_to_their_standard_deviations_and_nothing_beyond) {
  const Camera camera = test::front_camera(241, 161);
  GaussianCloud cloud = test::single_gaussian({0, 0, 5}, 1, {1, 1, 1}, 0);
  cloud.log_scales[0] = {std::log(1.2f), std::log(0.4f), std::log(0.4f)};
  for (const char* mode : kSomeModes) {
    for (const float scale : {1.0f, 0.5f}) {
      SCOPED_TRACE(testing::Message() << mode << " " << scale);
      RenderSettings settings = drawn_as(DrawStyle::ellipsoids, mode);
      settings.splat_scale = scale;
      const glm::dvec2 sigma = static_cast<double>(scale) / 5 * camera.focal_px *
                               glm::dvec2(static_cast<double>(1.2f), static_cast<double>(0.4f));
      expect_solid(picture_of(cloud, camera, settings).color, glm::sqrt(sigma * sigma + kDilation));
    }
  }
}

TEST(Points, have_one_radius_near_and_far) {
  const Camera camera = test::front_camera(41, 41);
  for (const char* mode : kSomeModes) {
    for (const float depth : {0.5f, 5.0f, 5000.0f}) {
      for (const double radius : {1.0, 2.5, 8.0}) {
        SCOPED_TRACE(testing::Message() << mode << " " << depth << " " << radius);
        RenderSettings settings = drawn_as(DrawStyle::points, mode);
        settings.splat_scale = static_cast<float>(radius / kPointRadius);
        expect_solid(
            picture_of(test::single_gaussian({0, 0, depth}, 1, {1, 1, 1}, 0), camera, settings)
                .color,
            glm::dvec2(radius));
      }
    }
  }
}

TEST(Points, of_a_frame_of_half_the_size_have_half_the_radius) {
  const GaussianCloud cloud = test::single_gaussian({0, 0, 3}, 1, {1, 1, 1}, 0);
  RenderSettings settings = drawn_as(DrawStyle::points);
  settings.splat_scale = static_cast<float>(8 / kPointRadius);
  settings.dilation /= 4;
  expect_solid(picture_of(cloud, test::front_camera(21, 21), settings).color, glm::dvec2(4));
}

}  // namespace
}  // namespace qs
