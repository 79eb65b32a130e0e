// SPDX-License-Identifier: MIT
// Tiles that list tens of thousands of Gaussians, and alphas close to 1/255: the images equal the
// CPU's, which composites one Gaussian after the other.
#include <algorithm>
#include <cmath>
#include <random>

#include "support/gpu.h"
#include "support/scenes.h"

namespace qs {
namespace {

class CudaLongLists : public test::PipelineTest {
 protected:
  static RenderSettings settings_on(glm::vec3 background) {
    RenderSettings settings = settings_of_pipeline();
    settings.background = background;
    return settings;
  }
};

INSTANTIATE_TEST_SUITE_P(Pipelines, CudaLongLists, test::kPipelines, test::name_of_pipeline);

constexpr int kSide = 16;             // px: one tile
constexpr std::uint64_t kCut = 2048;  // `fast` cuts lists above this length here (segments.cuh)
constexpr glm::vec3 kBlack(0), kWhite(1);

float logit(double opacity) { return static_cast<float>(std::log(opacity / (1 - opacity))); }

/// `count` Gaussians of about a pixel each, all inside one tile, in random order of depth.
GaussianCloud crowd(std::size_t count, double least_opacity, double most_opacity) {
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const Camera camera = test::front_camera(kSide, kSide);
  GaussianCloud cloud;
  cloud.resize(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const double z = uniform(2, 6), px = z / camera.focal_px.x, middle = camera.center_px.x;
    cloud.positions[i] = {(uniform(0, kSide - 1) - middle) * px,
                          (uniform(0, kSide - 1) - middle) * px, z};
    for (int axis = 0; axis < 3; ++axis) {
      cloud.log_scales[i][axis] = static_cast<float>(std::log(uniform(0.1, 0.6) * px));
    }
    cloud.rotations[i] = glm::quat(1, 0, 0, 0);
    cloud.opacity_logits[i] = logit(uniform(least_opacity, most_opacity));
    cloud.sh[i] = glm::vec3(uniform(-1.7, 1.7), uniform(-1.7, 1.7), uniform(-1.7, 1.7));
  }
  return cloud;
}

/// Layers at the same depth that cover every pixel with their opacity.
void append_layers(GaussianCloud& cloud, std::size_t count, double opacity, glm::vec3 color) {
  for (std::size_t i = 0; i < count; ++i) {
    test::append(cloud, test::single_gaussian({0, 0, 3}, 1000.0f, color, logit(opacity)));
  }
}

double largest_difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.values.size(), b.values.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    largest = std::max(largest, std::abs(double{a.values[i]} - double{b.values[i]}));
  }
  return largest;
}

/// Share of the pixels that stop before the end of their list, from the CPU.
double share_of_stopping(const Frame& frame) {
  const auto list = frame.stats.max_pairs_in_a_tile;
  const auto stop = std::count_if(frame.evaluated.begin(), frame.evaluated.end(),
                                  [&](std::uint32_t entries) { return entries < list; });
  return static_cast<double>(stop) / static_cast<double>(frame.evaluated.size());
}

TEST_P(CudaLongLists, are_drawn_as_on_the_cpu_whether_pixels_stop_or_not) {
  Outputs maps;
  maps.evaluated = true;
  struct Case {
    double least_opacity, most_opacity, stops_at_least, stops_at_most;
  };
  const Camera camera = test::front_camera(kSide, kSide);
  for (const Case& c : {Case{0.004, 0.012, 0, 0}, {0.05, 0.1, 0.05, 0.95}, {0.02, 0.4, 0.9, 1}}) {
    SCOPED_TRACE(testing::Message() << "opacity up to " << c.most_opacity);
    const GaussianCloud cloud = crowd(20000, c.least_opacity, c.most_opacity);
    const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
    for (const glm::vec3 background : {kBlack, kWhite}) {
      const Frame& expected = cpu->render(camera, settings_on(background), maps);
      ASSERT_GT(expected.stats.max_pairs_in_a_tile, 15000u);
      EXPECT_GE(share_of_stopping(expected), c.stops_at_least);
      EXPECT_LE(share_of_stopping(expected), c.stops_at_most);
      const Image image = gpu->render(camera, settings_on(background)).color;
      // A pixel may stop one Gaussian earlier or later, at a transmittance of 1e-4.
      EXPECT_LE(largest_difference(image, expected.color), c.stops_at_most > 0 ? 1e-4 : 1e-5);
    }
  }
}

/// Positions of the first segments' borders in a list of `count` Gaussians in the order of the file
/// that all reach a pixel: as segments.cuh cuts it, at samples.
std::vector<std::size_t> borders_of_segments(std::uint32_t count) {
  std::vector<std::size_t> samples;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint32_t hash = (i ^ i >> 16) * 0x85ebca6bu;
    hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
    if ((hash ^ hash >> 16) % 8 == 0) samples.push_back(i);
  }
  constexpr std::size_t kEach = 16;  // samples in a segment of a small picture
  return {samples.at(kEach), samples.at(2 * kEach)};
}

TEST_P(CudaLongLists, stop_exactly_at_and_beside_the_borders_of_segments) {
  const Camera camera = test::front_camera(kSide, kSide);
  Outputs maps;
  maps.evaluated = true;
  constexpr std::uint32_t kLength = 5600;
  for (const std::size_t border : borders_of_segments(kLength)) {
    for (const std::size_t in_front : {border - 2, border - 1, border, border + 1}) {
      SCOPED_TRACE(in_front);
      GaussianCloud cloud;
      // Transmittance 1.5e-4 is left for a Gaussian that would leave less than 1e-4.
      const double opacity = 1 - std::pow(1.5e-4, 1.0 / static_cast<double>(in_front));
      append_layers(cloud, in_front, opacity, {0.2f, 0.4f, 0.6f});
      append_layers(cloud, 1, 0.98, {1, 0, 1});
      append_layers(cloud, kLength - in_front - 1, 0.02, {0, 1, 0});
      const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
      for (const glm::vec3 background : {kBlack, kWhite}) {
        const Frame& expected = cpu->render(camera, settings_on(background), maps);
        ASSERT_EQ(expected.evaluated[0], in_front + 1);
        EXPECT_LE(
            largest_difference(gpu->render(camera, settings_on(background)).color, expected.color),
            1e-5);
      }
    }
  }
}

TEST_P(CudaLongLists, of_opaque_gaussians_are_drawn_as_on_the_cpu) {
  GaussianCloud cloud = crowd(6000, 0.1, 0.9);
  for (float& opacity : cloud.opacity_logits) opacity = INFINITY;
  const Camera camera = test::front_camera(kSide, kSide);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  for (const glm::vec3 background : {kBlack, kWhite}) {
    test::expect_same_image(gpu->render(camera, settings_on(background)).color,
                            cpu->render(camera, settings_on(background)).color);
  }
}

TEST_P(CudaLongLists, do_not_depend_on_how_they_are_cut_or_on_how_alphas_are_compared) {
  // Maps are made in one walk through the list, which compares alphas with 1/255.
  Outputs maps;
  maps.evaluated = true;
  const Camera camera = test::front_camera(kSide, kSide);
  for (const double opacity : {0.012, 0.05, 0.4}) {
    const auto gpu = renderer_of(Backend::cuda, crowd(20000, 0.004, opacity));
    const Image whole = gpu->render(camera, settings_on(kWhite), maps).color;
    EXPECT_LE(largest_difference(gpu->render(camera, settings_on(kWhite)).color, whole), 1e-4)
        << opacity;
  }
}

TEST_P(CudaLongLists, are_equal_bit_for_bit_in_every_run) {
  const GaussianCloud cloud = crowd(20000, 0.004, 0.05);
  const Camera camera = test::front_camera(kSide, kSide);
  const auto gpu = renderer_of(Backend::cuda, cloud);
  // The first frame exceeds the buffers and is redrawn.
  const Image first = gpu->render(camera, settings_on(kBlack)).color;
  EXPECT_EQ(gpu->render(camera, settings_on(kBlack)).color.values, first.values);
  EXPECT_EQ(renderer_of(Backend::cuda, cloud)->render(camera, settings_on(kBlack)).color.values,
            first.values);
}

TEST_P(CudaLongLists, do_not_depend_on_the_lists_of_the_frame_before) {
  const GaussianCloud cloud = crowd(20000, 0.004, 0.05);
  const Camera crowded = test::front_camera(kSide, kSide), wide = test::front_camera(400, 400);
  const auto gpu = renderer_of(Backend::cuda, cloud);
  const Image first = gpu->render(crowded, settings_on(kBlack)).color;
  for (int i = 0; i < 2; ++i) {
    ASSERT_LT(gpu->render(wide, settings_on(kBlack)).stats.max_pairs_in_a_tile, kCut / 2);
    EXPECT_EQ(gpu->render(crowded, settings_on(kBlack)).color.values, first.values);
  }
}

TEST_P(CudaLongLists, are_equal_bit_for_bit_in_lossless_modes) {
  GaussianCloud cloud = test::random_cloud(4000, 0, 3);
  test::append(cloud, crowd(24000, 0.004, 0.2));
  const auto gpu = renderer_of(Backend::cuda, cloud);
  for (const auto& [width, height] : {std::pair{16, 16}, {45, 37}}) {
    const Camera camera = test::front_camera(width, height);
    RenderSettings settings = settings_on(kWhite);
    settings.mode = find_culler("adr");
    const Frame adr = gpu->render(camera, settings);
    settings.mode = find_culler("exact");
    const Frame& exact = gpu->render(camera, settings);
    ASSERT_GT(exact.stats.max_pairs_in_a_tile, kCut);
    ASSERT_LT(exact.stats.tile_pairs, adr.stats.tile_pairs);
    EXPECT_EQ(exact.color.values, adr.color.values);
    settings.mode = find_culler("quadbox");
    EXPECT_EQ(gpu->render(camera, settings).color.values, adr.color.values);
  }
}

TEST_P(CudaLongLists, of_hundreds_of_segments_are_drawn_as_on_the_cpu) {
  // Hundreds of segments are joined in groups.
  constexpr std::size_t kCount = 131146;
  const Camera camera = test::front_camera(kSide, kSide);
  GaussianCloud cloud = crowd(kCount, 0.0045, 0.0045);
  const auto onto_pixel = [](double along, double px, double center) {
    return (std::round(along / px + center) - center) * px;
  };
  for (auto& position : cloud.positions) {  // to the nearest pixel, the only one that it reaches
    const glm::dvec2 px = double{position.z} / camera.focal_px;
    position.x = static_cast<float>(onto_pixel(position.x, px.x, camera.center_px.x));
    position.y = static_cast<float>(onto_pixel(position.y, px.y, camera.center_px.y));
  }
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  const Frame& expected = cpu->render(camera, settings_on(kWhite));
  ASSERT_EQ(expected.stats.max_pairs_in_a_tile, kCount);
  EXPECT_LE(largest_difference(gpu->render(camera, settings_on(kWhite)).color, expected.color),
            1e-4);
}

TEST_P(CudaLongLists, of_several_tiles_beside_short_ones_are_drawn_as_on_the_cpu) {
  GaussianCloud cloud = test::random_cloud(2000, 0, 3);
  test::append(cloud, crowd(24000, 0.01, 0.2));
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  for (const auto& [width, height] : {std::pair{16, 16}, {45, 37}, {130, 70}}) {
    const Camera camera = test::front_camera(width, height);
    const Frame& expected = cpu->render(camera, settings_on(kWhite));
    if (width < 100) {
      ASSERT_GT(expected.stats.max_pairs_in_a_tile, kCut);
    }
    test::expect_same_image(gpu->render(camera, settings_on(kWhite)).color, expected.color);
  }
}

TEST_P(CudaLongLists, alphas_around_1_255_are_skipped_below_it_only) {
  const Camera camera = test::front_camera(17, 17);  // the middle of the image is a pixel
  RenderSettings settings = settings_of_pipeline();
  settings.mode = find_culler("3dgs");  // keeps Gaussians below 1/255
  const auto middle = [](const Image& image) { return image.at(8, 8, 1); };
  for (const double relative : {1e-2, 1e-3, 1e-4, 2e-5}) {
    for (const double sign : {-1.0, 1.0}) {
      const double opacity = (1 + sign * relative) / 255;
      const auto gpu = renderer_of(
          Backend::cuda, test::single_gaussian({0, 0, 3}, 0.2f, {1, 1, 1}, logit(opacity)));
      const float value = middle(gpu->render(camera, settings).color);
      if (sign > 0) {
        EXPECT_NEAR(value, opacity, 1e-8) << relative;
      } else {
        EXPECT_EQ(value, 0.0f) << relative;
      }
    }
  }
}

}  // namespace
}  // namespace qs
