// SPDX-License-Identifier: MIT
#include "raster/scene/cloud_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "support/scenes.h"

namespace qs::test {
namespace {

GaussianCloud flat_cloud(std::span<const float> sizes) {
  GaussianCloud cloud = random_cloud(sizes.size(), 0, 3);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    cloud.log_scales[i] = glm::vec3(sizes[i], sizes[i], -INFINITY);
    cloud.opacity_logits[i] = 0;
  }
  return cloud;
}

TEST(CloudOrder, the_largest_are_kept_in_their_order) {
  const float sizes[] = {-3, -1, -5, -2, -4};
  GaussianCloud cloud = flat_cloud(sizes);
  cloud.opacity_logits[1] = -INFINITY;
  const GaussianCloud kept = keep_largest(cloud, 2);
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept.positions[0], cloud.positions[0]);
  EXPECT_EQ(kept.positions[1], cloud.positions[3]);
  EXPECT_EQ(keep_largest(cloud, 5).size(), 5u);
  EXPECT_EQ(keep_largest(cloud, 99).size(), 5u);
}

TEST(CloudOrder, size_is_opacity_times_the_two_largest_standard_deviations) {
  const GaussianCloud cloud = random_cloud(500, 0, 9);
  const auto size_of = [&](std::uint32_t i) {
    double s[] = {cloud.log_scales[i].x, cloud.log_scales[i].y, cloud.log_scales[i].z};
    std::sort(std::begin(s), std::end(s));
    return std::exp(s[1]) * std::exp(s[2]) / (1 + std::exp(-double{cloud.opacity_logits[i]}));
  };
  const auto order = largest_first(cloud);
  ASSERT_EQ(order.size(), 500u);
  for (std::size_t i = 1; i < order.size(); ++i)
    EXPECT_GE(size_of(order[i - 1]), size_of(order[i]) * (1 - 1e-6)) << i;
}

TEST(CloudOrder, equal_sizes_keep_their_order) {
  const float sizes[] = {-2, -1, -2, -1, -2};
  EXPECT_EQ(largest_first(flat_cloud(sizes)), (std::vector<std::uint32_t>{1, 3, 0, 2, 4}));
}

TEST(CloudOrder, morton_order_interleaves_the_bits_of_x_y_and_z) {
  GaussianCloud cloud;
  cloud.resize(8, 0);  // the corners of a box, x fastest
  for (std::size_t i = 0; i < 8; ++i) cloud.positions[i] = {i & 1, 2 * (i >> 1 & 1), 3 * (i >> 2)};
  std::reverse(cloud.positions.begin(), cloud.positions.end());
  EXPECT_EQ(morton_order(cloud), (std::vector<std::uint32_t>{7, 6, 5, 4, 3, 2, 1, 0}));
}

TEST(CloudOrder, neighbours_on_the_curve_are_neighbours_in_space) {
  const GaussianCloud cloud = surrounding_cloud(4000, 0, 11);
  const auto order = morton_order(cloud);
  auto numbers = order;
  std::sort(numbers.begin(), numbers.end());
  for (std::uint32_t i = 0; i < numbers.size(); ++i) ASSERT_EQ(numbers[i], i);
  const auto mean_step = [](const GaussianCloud& of) {
    double sum = 0;
    for (std::size_t i = 1; i < of.size(); ++i)
      sum += glm::distance(of.positions[i], of.positions[i - 1]);
    return sum / static_cast<double>(of.size());
  };
  EXPECT_LT(mean_step(select(cloud, order)), 0.3 * mean_step(cloud));
}

TEST(CloudOrder, select_copies_every_attribute) {
  GaussianCloud cloud = random_cloud(10, 2, 4);
  cloud.antialiased = true;
  const std::uint32_t numbers[] = {7, 0, 7};
  const GaussianCloud chosen = select(cloud, numbers);
  ASSERT_EQ(chosen.size(), 3u);
  EXPECT_TRUE(chosen.antialiased);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t from = numbers[i];
    EXPECT_EQ(chosen.positions[i], cloud.positions[from]);
    EXPECT_EQ(chosen.log_scales[i], cloud.log_scales[from]);
    EXPECT_EQ(chosen.rotations[i], cloud.rotations[from]);
    EXPECT_EQ(chosen.opacity_logits[i], cloud.opacity_logits[from]);
    for (std::size_t k = 0; k < 9; ++k) EXPECT_EQ(chosen.sh[9 * i + k], cloud.sh[9 * from + k]);
  }
}

}  // namespace
}  // namespace qs::test
