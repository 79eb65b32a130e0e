// SPDX-License-Identifier: MIT
//
// Points of surfaces on planes at known distances.
#include "raster/select/surface.h"

#include <cmath>
#include <random>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/pool.h"
#include "support/scenes.h"

namespace qs::test {
namespace {

constexpr int kSideOfPlane = 65;

// Gaussians on the plane through `middle`, turned about the x axis by `tilt`, from a lattice with a
// spacing of one standard deviation. Their centres lie up to `thickness` off the plane.
GaussianCloud plane(glm::dvec3 middle, double tilt, double sigma, double thickness,
                    double opacity) {
  constexpr int kHalf = 40;
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1);
  const glm::dquat turn = glm::angleAxis(tilt, glm::dvec3(1, 0, 0));
  GaussianCloud cloud;
  cloud.resize((2 * kHalf + 1) * (2 * kHalf + 1), 0);
  std::size_t i = 0;
  for (int y = -kHalf; y <= kHalf; ++y)
    for (int x = -kHalf; x <= kHalf; ++x, ++i) {
      const double off = thickness > 0 ? thickness * normal(random) : 0;
      cloud.positions[i] = glm::vec3(middle + turn * glm::dvec3(x * sigma, y * sigma, off));
      const auto log_sigma = static_cast<float>(std::log(sigma));
      cloud.log_scales[i] = {log_sigma, log_sigma,
                             thickness > 0 ? static_cast<float>(std::log(thickness)) : -INFINITY};
      cloud.rotations[i] = glm::quat(turn);
      cloud.opacity_logits[i] = static_cast<float>(std::log(opacity / (1 - opacity)));
      cloud.sh[i] = glm::vec3(0);
    }
  return cloud;
}

std::optional<SurfacePoint> point_of(const GaussianCloud& cloud, const Camera& camera,
                                     glm::ivec2 pixel) {
  const auto renderer = make_renderer(Backend::cpu, pool());
  renderer->upload(GaussianCloud(cloud), {});
  return surface_at(renderer->render(camera, {}, {.color = false, .trace = true}), cloud, camera,
                    pixel);
}

double distance_of_plane(glm::dvec3 middle, double tilt, glm::dvec3 direction) {
  const glm::dvec3 normal(0, -std::sin(tilt), std::cos(tilt));
  return glm::dot(normal, middle) / glm::dot(normal, direction);
}

TEST(Surface, of_flat_gaussians_is_their_plane_and_not_their_centres) {
  const Camera camera = front_camera(kSideOfPlane, kSideOfPlane);
  for (const double degrees : {0.0, 15.0, 30.0, 45.0, 52.0, 60.0, 65.0, 70.0, 73.0, 75.0}) {
    for (const double far : {1.0, 10.0, 1000.0}) {
      SCOPED_TRACE(fmt::format("{} degrees, {} away", degrees, far));
      const double tilt = degrees * std::acos(-1.0) / 180;
      const glm::dvec3 middle(0.01 * far, 0.02 * far, far);
      const GaussianCloud cloud = plane(middle, tilt, 0.05 * far, 0, 0.99);
      for (const glm::ivec2 pixel : {glm::ivec2(32, 32), glm::ivec2(25, 30), glm::ivec2(40, 36)}) {
        const auto point = point_of(cloud, camera, pixel);
        ASSERT_TRUE(point);
        const double expected = distance_of_plane(middle, tilt, point->direction);
        const double allowed = std::exp2(-20) * (expected + glm::length(middle)) / std::cos(tilt);
        EXPECT_NEAR(point->distance, expected, allowed);
        EXPECT_LE(point->along, allowed);
        EXPECT_FALSE(point->is_soft());
        EXPECT_LT(glm::distance(point->position, point->distance * point->direction), 1e-9 * far);
      }
    }
  }
}

TEST(Surface, of_a_rough_plane_is_within_its_uncertainty) {
  const Camera camera = front_camera(kSideOfPlane, kSideOfPlane);
  const GaussianCloud cloud = plane({0, 0, 10}, 0.5, 0.3, 0.1, 0.6);
  const auto renderer = make_renderer(Backend::cpu, pool());
  renderer->upload(GaussianCloud(cloud), {});
  const Frame& frame = renderer->render(camera, {}, {.color = false, .trace = true});
  std::mt19937 random(9);
  int within = 0;
  for (int i = 0; i < 500; ++i) {
    const glm::ivec2 pixel(12 + random() % 40, 12 + random() % 40);
    const auto point = surface_at(frame, cloud, camera, pixel);
    ASSERT_TRUE(point);
    const double expected = distance_of_plane({0, 0, 10}, 0.5, point->direction);
    within += std::abs(point->distance - expected) <= 2 * point->along;
    EXPECT_LT(point->along, 0.3);
  }
  EXPECT_GE(within, 475);
}

TEST(Surface, is_behind_a_faint_floater_and_nowhere_without_half_of_the_light) {
  const Camera camera = front_camera(kSideOfPlane, kSideOfPlane);
  GaussianCloud cloud = plane({0, 0, 10}, 0.3, 0.5, 0, 0.99);
  const glm::ivec2 pixel(30, 33);
  const auto before = point_of(cloud, camera, pixel);
  append(cloud, single_gaussian({0, 0, 2}, 0.5f, glm::vec3(1), std::log(0.2f / 0.8f)));
  const auto after = point_of(cloud, camera, pixel);
  ASSERT_TRUE(before && after);
  EXPECT_EQ(before->distance, after->distance);
  const GaussianCloud faint = single_gaussian({0, 0, 5}, 1, glm::vec3(1), -0.5f);
  EXPECT_FALSE(point_of(faint, camera, {32, 32}));
  EXPECT_FALSE(point_of(cloud, camera, {-1, 3}));
  EXPECT_FALSE(point_of(cloud, camera, {0, kSideOfPlane}));
}

TEST(Surface, distances_have_the_uncertainty_of_both_ends) {
  const SurfacePoint a{{0, 0, 10}, {0, 0, 1}, 10, 0.3, 0.01};
  const SurfacePoint beside{{4, 3, 10}, {0, 0, 1}, 10, 0.4, 0.02};
  const SurfacePoint behind{{0, 0, 12}, {0, 0, 1}, 12, 0.4, 0.02};
  EXPECT_DOUBLE_EQ(length_between(a, beside).length, 5);
  EXPECT_DOUBLE_EQ(length_between(a, beside).error, std::hypot(0.01, 0.02));
  EXPECT_DOUBLE_EQ(length_between(a, behind).length, 2);
  EXPECT_DOUBLE_EQ(length_between(a, behind).error, std::hypot(0.3, 0.4));
  EXPECT_EQ(length_between(a, a).length, 0);
  EXPECT_DOUBLE_EQ(length_between(a, a).error, std::hypot(0.3, 0.3));
}

// Two cameras look at a place from an angle; 500 clicks of each are off by less than a pixel.
TEST(Sights, cross_at_the_place_that_both_see_within_the_uncertainty) {
  const glm::dvec3 place(0.2, -0.1, 5);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off(-0.5, 0.5);
  for (const double degrees : {5.0, 40.0, 90.0, 140.0}) {
    const double angle = glm::radians(degrees);
    const glm::dvec3 second = place + 3.0 * glm::dvec3(std::sin(angle), 0, -std::cos(angle));
    const Camera cameras[] = {look_at({0.2, -0.1, 0}, place, {0, -1, 0}, 1, 800, 600),
                              look_at(second, place, {0, -1, 0}, 1, 800, 600)};
    const auto sight = [&](int camera, glm::dvec2 by) {
      return sight_of(cameras[camera], cameras[camera].center_px + by);
    };
    const auto exact = crossing(sight(0, {0, 0}), sight(1, {0, 0}));
    ASSERT_TRUE(exact);
    EXPECT_LT(glm::distance(exact->point.position, place), 1e-9);
    EXPECT_LT(exact->gap, 1e-9);
    EXPECT_NEAR(exact->point.distance, 5, 1e-9);
    double along = 0, across = 0, most = 0;  // sums of squares
    for (int click = 0; click < 500; ++click) {
      const auto by = [&] { return glm::dvec2(off(random), off(random)); };
      const auto found = crossing(sight(0, by()), sight(1, by()));
      ASSERT_TRUE(found);
      const glm::dvec3 error = found->point.position - place;
      const double part = glm::dot(error, exact->point.direction);
      along += part * part;
      across += (glm::dot(error, error) - part * part) / 2;
      most = std::max(most, found->gap);
      EXPECT_GE(found->point.along, 0.9 * exact->point.along);
    }
    // The uncertainty is a bound: as of the worse line, and as along the worst direction.
    EXPECT_LE(std::sqrt(along / 500), 1.1 * exact->point.along) << degrees;
    EXPECT_GE(std::sqrt(along / 500), 0.25 * exact->point.along) << degrees;
    EXPECT_LE(std::sqrt(across / 500), 1.1 * exact->point.across) << degrees;
    EXPECT_GT(most, 0);
  }
}

TEST(Sights, do_not_cross_if_they_are_parallel_or_meet_behind_an_eye) {
  const Sight ahead{{0, 0, 0}, {0, 0, 1}, 0.001};
  EXPECT_FALSE(crossing(ahead, ahead));
  EXPECT_FALSE(crossing(ahead, {{1, 0, 0}, {0, 0, 1}, 0.001}));
  EXPECT_FALSE(crossing(ahead, {{1, 0, 0}, {0, 0, -1}, 0.001}));
  EXPECT_FALSE(crossing(ahead, {{1, 0, 0}, glm::normalize(glm::dvec3(1, 0, 1)), 0.001}));
  const auto missed = crossing(ahead, {{1, 0.25, 3}, {-1, 0, 0}, 0.001});
  ASSERT_TRUE(missed);
  EXPECT_EQ(missed->point.position, glm::dvec3(0, 0.125, 3));
  EXPECT_DOUBLE_EQ(missed->gap, 0.25);
  EXPECT_GE(missed->point.along, 0.125);
  const Sight back = sight_of(SurfacePoint{{0, 0, 4}, {0, 0, 1}, 4, 0.1, 0.02});
  EXPECT_EQ(back.eye, glm::dvec3(0, 0, 0));
  EXPECT_DOUBLE_EQ(back.across, 0.005);
}

TEST(Surface, a_gaussian_is_densest_where_its_density_is) {
  const GaussianCloud cloud = random_cloud(300, 0, 21);
  const glm::dvec3 eye(0.3, -0.2, -1), direction = glm::normalize(glm::dvec3(0.1, 0.2, 1));
  int behind = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 scale = glm::exp(glm::dvec3(cloud.log_scales[i]));
    if (std::min({scale.x, scale.y, scale.z}) < 1e-4) continue;
    const auto [at, sigma] = on_ray(cloud, i, eye, direction);
    const auto exponent = [&](double t) {
      const glm::dvec3 offset = eye + t * direction - glm::dvec3(cloud.positions[i]);
      const glm::dvec3 own =
          glm::conjugate(glm::normalize(glm::dquat(cloud.rotations[i]))) * offset / scale;
      return glm::dot(own, own);
    };
    if (at == 0) {
      ++behind;
      EXPECT_GE(exponent(1e-3), exponent(0));
      continue;
    }
    const double least = exponent(at);
    EXPECT_LE(least, exponent(at * 1.001));
    EXPECT_LE(least, exponent(at * 0.999));
    EXPECT_NEAR(exponent(at + sigma) - least, 1, 1e-6 * (1 + least));
  }
  EXPECT_GT(behind, 0);
}

}  // namespace
}  // namespace qs::test
