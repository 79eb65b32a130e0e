// SPDX-License-Identifier: MIT
// Reduced frames against the full frame, and the choice of the reduction.
#include "app/viewer/render/resolution.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "io/camera/cameras.h"
#include "raster/scene/image_metrics.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace qs {
namespace {

double mean(const Image& image) {
  double sum = 0;
  for (const float value : image.values) sum += static_cast<double>(std::clamp(value, 0.0f, 1.0f));
  return sum / static_cast<double>(image.values.size());
}

/// Reduced frames of the views of a scene at 1280x720 keep the full frame's mean within `share`,
/// and their PSNR against its box-filtered pixels is at least `psnr`, less 4 dB per divisor
/// beyond 2.
void expect_reduced_frames_of(const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                              double share, double psnr) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(cloud, {});
  for (std::size_t view = 0; view < cameras.size(); view += (cameras.size() + 2) / 3) {
    const Camera camera = cameras[view].resized(1280, 720);
    const Image full = renderer->render(camera).color;
    for (const int divisor : {2, 3, 4}) {
      SCOPED_TRACE(testing::Message() << "view " << view << ", divisor " << divisor);
      const Camera smaller = camera.reduced(divisor);
      const Image image = renderer->render(smaller, reduced(RenderSettings(), divisor)).color;
      EXPECT_NEAR(mean(image) / mean(full), 1, share);
      const Image boxes = area_average(full, smaller.width, smaller.height, test::pool(2));
      EXPECT_GE(psnr_8bit(image, boxes), psnr - 4 * (divisor - 2));
    }
  }
}

TEST(ReducedFrames, of_the_bundled_scene_are_as_bright_as_the_full_frame_and_look_like_it) {
  expect_reduced_frames_of(test::read_scene(test::source_path("assets/plush.ply")).cloud,
                           read_cameras(test::source_path("assets/cameras.json")), 0.01, 48);
}

TEST(ReducedFrames, of_large_scenes_are_as_bright_as_the_full_frame_and_look_like_it) {
  QS_NEEDS_SHARED("scenes/plush.spz");
  expect_reduced_frames_of(test::read_scene(test::shared_path("scenes/plush.spz")).cloud,
                           read_cameras(test::shared_path("scenes/plush/cameras.json")), 0.01, 40);
}

TEST(ReducedFrames, of_gaussians_far_smaller_than_a_pixel_are_as_bright_as_the_full_frame) {
  // With the full frame's dilation in the reduced frame's own pixels they are 4 times as bright.
  GaussianCloud cloud;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(-1, 1);
  for (int i = 0; i < 4000; ++i)
    test::append(cloud, test::single_gaussian({place(random), place(random), 3}, 1e-4f,
                                              {0.9f, 0.5f, 0.2f}, 2));
  Camera camera = test::front_camera(640, 480);
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(cloud, {});
  const double full = mean(renderer->render(camera).color);
  const double undilated = mean(renderer->render(camera.reduced(2)).color);
  EXPECT_GT(undilated / full, 2);
  for (const int divisor : {2, 3}) {
    const auto settings = reduced(RenderSettings(), divisor);
    EXPECT_NEAR(mean(renderer->render(camera.reduced(divisor), settings).color) / full, 1, 0.05);
  }
}

TEST(ReducedFrames, keep_every_point_s_place_in_the_window) {
  // 1280 is no multiple of 3, and the principal point is not in the middle.
  Camera camera = test::front_camera(1280, 719);
  camera.center_px = {600.25, 380.5};
  for (const int divisor : {1, 2, 3, 7}) {
    const Camera smaller = camera.reduced(divisor);
    EXPECT_EQ(smaller.width, 1280 / divisor);
    EXPECT_EQ(smaller.height, 719 / divisor);
    for (const glm::dvec2 slope : {glm::dvec2(0), glm::dvec2(0.3, -0.2), glm::dvec2(-0.5, 0.4)}) {
      const auto place = [&](const Camera& c) {
        return (c.focal_px * slope + c.center_px + 0.5) / glm::dvec2(c.width, c.height);
      };
      EXPECT_NEAR(place(smaller).x, place(camera).x, 1e-12);
      EXPECT_NEAR(place(smaller).y, place(camera).y, 1e-12);
    }
  }
  EXPECT_EQ(test::front_camera(5, 3).reduced(8).width, 1);
  EXPECT_EQ(test::front_camera(5, 3).reduced(8).height, 1);
}

TEST(ReducedFrames, that_are_not_reduced_are_the_full_frame) {
  const Camera camera = test::front_camera(333, 77);
  EXPECT_EQ(camera.reduced(1).focal_px, camera.focal_px);
  EXPECT_EQ(camera.reduced(1).center_px, camera.center_px);
  EXPECT_EQ(reduced(RenderSettings(), 1).dilation, 0.3);
}

TEST(Refinement, goes_by_a_third_and_a_half_to_the_full_frame) {
  EXPECT_EQ(refined(8), 3);
  EXPECT_EQ(refined(4), 3);
  EXPECT_EQ(refined(3), 2);
  EXPECT_EQ(refined(2), 1);
  EXPECT_EQ(refined(1), 1);
}

// ---- the choice ---------------------------------------------------------------------------------
/// A flight in which a frame reduced by n takes fixed + pixels / n^2 ms.
struct Flight {
  double fixed, pixels;
  double noise = 0;  // largest part by which a time is off
  Resolution resolution = {};
  std::mt19937 random{1};

  double pixels_ms(int divisor) const { return pixels / (divisor * divisor); }
  double ms(int divisor) const { return fixed + pixels_ms(divisor); }
  FrameCost cost(int divisor) const { return {ms(divisor), pixels_ms(divisor)}; }

  /// Draws frames; returns the number of changes of the divisor.
  int frames(int count) {
    std::uniform_real_distribution<double> off(-noise, noise);
    int changes = 0;
    for (int i = 0; i < count; ++i) {
      const int before = resolution.divisor();
      const double factor = 1 + off(random);
      resolution.learn(before, {factor * ms(before), factor * pixels_ms(before)});
      changes += resolution.divisor() != before;
    }
    return changes;
  }
};

TEST(Resolution, comes_to_rest_at_every_cost_where_frames_are_quick_enough) {
  for (const double noise : {0.0, 0.1}) {
    for (double fixed = 0; fixed < 60; fixed += 1.7) {
      for (double pixels = 1; pixels < 4000; pixels *= 1.3) {
        SCOPED_TRACE(testing::Message() << fixed << " + " << pixels << " ms, noise " << noise);
        Flight flight{fixed, pixels, noise};
        flight.frames(60);
        // With noise a divisor may turn out late to be too slow, but it is never chosen again.
        EXPECT_LE(flight.frames(300), noise > 0 ? 1 : 0);
        const int n = flight.resolution.divisor();
        if (n < 3 || (n < kMostDivisor && flight.ms(n + 1) < 0.75 * flight.ms(n))) {
          EXPECT_LE(flight.ms(n), longest_moving_ms(n) * (1 + 2 * noise));
        }
        if (n > 1) {  // and not smaller than necessary
          EXPECT_GT(flight.ms(n) * n * n / ((n - 1) * (n - 1)),
                    0.8 * longest_moving_ms(n - 1) * (1 - 2 * noise));
        }
      }
    }
  }
}

TEST(Resolution, is_not_below_a_third_if_twenty_pictures_a_second_can_be_held) {
  for (double fixed = 0; fixed <= 50; fixed += 1) {
    Flight flight{fixed, 9 * (50 - fixed)};  // a third takes 50 ms
    flight.frames(100);
    EXPECT_LE(flight.resolution.divisor(), 3) << fixed;
  }
}

TEST(Resolution, is_found_from_the_first_full_frame_if_only_pixels_cost_time) {
  for (const auto& [ms, divisor] : {std::pair{20.0, 1}, {100.0, 2}, {200.0, 3}, {600.0, 4}}) {
    Resolution resolution;
    resolution.learn(1, {ms, ms});
    EXPECT_EQ(resolution.divisor(), divisor) << ms;
  }
  Resolution resolution;
  resolution.learn(1, {1e9, 1e9});
  EXPECT_EQ(resolution.divisor(), kMostDivisor);
}

TEST(Resolution, is_not_below_a_third_if_that_saves_little) {
  Flight flight{150, 400};  // 194 ms a third, 175 ms a quarter
  flight.frames(100);
  EXPECT_EQ(flight.resolution.divisor(), 3);
  flight.fixed = 30;
  flight.pixels = 1600;
  flight.frames(100);
  EXPECT_GT(flight.resolution.divisor(), 3);
}

TEST(Resolution, follows_a_change_of_the_costs_in_both_directions) {
  Flight flight{2, 30};
  flight.frames(30);
  EXPECT_EQ(flight.resolution.divisor(), 2);
  flight.pixels = 300;
  EXPECT_EQ(flight.frames(5), 1);
  EXPECT_EQ(flight.resolution.divisor(), 3);
  flight.pixels = 12;
  flight.frames(20);
  EXPECT_EQ(flight.resolution.divisor(), 1);
}

TEST(Resolution, does_not_follow_one_disturbed_frame) {
  Flight flight{3, 80};
  flight.frames(30);
  ASSERT_EQ(flight.resolution.divisor(), 2);
  const double ms = 1.4 * longest_moving_ms(2);
  flight.resolution.learn(2, {ms, ms});
  EXPECT_EQ(flight.resolution.divisor(), 2);
  flight.resolution.learn(2, {1, 1});
  EXPECT_EQ(flight.frames(100), 0);
}

TEST(Resolution, stays_while_the_view_rests_and_is_refined) {
  Flight flight{10, 200};
  flight.frames(30);
  ASSERT_EQ(flight.resolution.divisor(), 3);
  for (const int divisor : {2, 1, 1}) flight.resolution.learn(divisor, flight.cost(divisor));
  EXPECT_EQ(flight.resolution.divisor(), 3);
}

}  // namespace
}  // namespace qs
