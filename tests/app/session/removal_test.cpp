// SPDX-License-Identifier: MIT
#include "raster/scene/removal.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "raster/scene/cloud_order.h"
#include "support/built_scenes.h"
#include "support/scenes.h"

namespace qs::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

// A table of 4 x 4 units that Gaussians of about 0.05 units cover.
GaussianCloud table() {
  SceneBuilder scene(3);
  scene.rectangle(6000, {0, 0, 5}, {2, 0, 0}, {0, 0, 2});
  return scene.cloud;
}

std::uint32_t plant(GaussianCloud& cloud, glm::vec3 position, float sigma, float opacity) {
  append(cloud, single_gaussian(position, sigma, {1, 0, 0}, 0));
  cloud.opacity_logits.back() = std::log(opacity / (1 - opacity));
  return static_cast<std::uint32_t>(cloud.size() - 1);
}

std::size_t count(const Removal& removal, Removed reason) {
  return removal.counts[static_cast<std::size_t>(reason)];
}

void expect_consistent(const Removal& removal) {
  RemovalCounts counted;
  for (const Removed mark : removal.marks) ++counted.counts[static_cast<std::size_t>(mark)];
  EXPECT_EQ(static_cast<const RemovalCounts&>(removal), counted);
  EXPECT_EQ(removal.all(), removal.marks.size());
}

TEST(Removal, nothing_goes_without_a_box_and_without_floaters) {
  const GaussianCloud cloud = table();
  const Removal removal = find_removal(cloud, {}, {});
  EXPECT_EQ(removal.going(), 0u);
  EXPECT_EQ(removal.all(), cloud.size());
  EXPECT_EQ(keep_rest(cloud, removal).positions, cloud.positions);
}

TEST(Removal, a_box_keeps_the_centres_in_it_and_on_its_border) {
  GaussianCloud cloud = random_cloud(6, 1, 2);
  const glm::vec3 positions[] = {{0, 0, 0},       {1, 2, 3},         {1, 2, 3.001f},
                                 {-0.001f, 0, 0}, {0.5f, 2.001f, 1}, {0.5f, 1, 1}};
  std::copy(std::begin(positions), std::end(positions), cloud.positions.begin());
  const Removal removal = find_removal(cloud, CropBox{{0, 0, 0}, {1, 2, 3}}, {});
  expect_consistent(removal);
  EXPECT_EQ(removal.marks, (std::vector<Removed>{Removed::no, Removed::no, Removed::outside,
                                                 Removed::outside, Removed::outside, Removed::no}));
  const GaussianCloud rest = keep_rest(cloud, removal);
  ASSERT_EQ(rest.size(), 3u);
  EXPECT_EQ(rest.positions[2], cloud.positions[5]);
  EXPECT_EQ(rest.sh[2 * 4 + 3], cloud.sh[5 * 4 + 3]);
}

TEST(Removal, planted_floaters_go_for_their_reason_and_the_table_stays) {
  GaussianCloud cloud = table();
  const std::size_t things = cloud.size();
  const std::uint32_t faint = plant(cloud, {0, 0, 5}, 0.05f, 0.01f);
  const std::uint32_t large = plant(cloud, {0, 0, 5}, 2.5f, 0.5f);
  const std::uint32_t alone = plant(cloud, {0, -2, 5}, 0.05f, 0.9f);
  const std::uint32_t far = plant(cloud, {1e6f, 0, 0}, 0.3f, 0.9f);
  const std::uint32_t farther = plant(cloud, {-1e30f, 0, 0}, 0.3f, 0.9f);
  const Removal removal = find_removal(cloud, {}, Floaters());
  expect_consistent(removal);
  EXPECT_EQ(removal.marks[faint], Removed::faint);
  EXPECT_EQ(removal.marks[large], Removed::large);
  for (const std::uint32_t i : {alone, far, farther})
    EXPECT_EQ(removal.marks[i], Removed::isolated);
  EXPECT_EQ(removal.going(), 5u);
  EXPECT_EQ(keep_rest(cloud, removal).size(), things);
}

TEST(Removal, each_criterion_is_switched_by_itself) {
  GaussianCloud cloud = table();
  plant(cloud, {0, 0, 5}, 0.05f, 0.01f);
  plant(cloud, {0, 0, 5}, 2.5f, 0.5f);
  plant(cloud, {0, -2, 5}, 0.05f, 0.9f);
  for (const int only : {1, 2, 3}) {
    Floaters floaters;
    floaters.faint = only == 1;
    floaters.large = only == 2;
    floaters.isolated = only == 3;
    const Removal removal = find_removal(cloud, {}, floaters);
    EXPECT_EQ(count(removal, Removed::faint), only == 1 ? 1u : 0u);
    EXPECT_EQ(count(removal, Removed::large), only == 2 ? 1u : 0u);
    EXPECT_EQ(count(removal, Removed::isolated), only == 3 ? 1u : 0u);
  }
}

TEST(Removal, limits_move_what_goes) {
  GaussianCloud cloud = table();
  const std::uint32_t half = plant(cloud, {0, 0, 5}, 0.05f, 0.5f);
  const std::uint32_t wide = plant(cloud, {0, 0, 5}, 0.5f, 0.9f);
  Floaters floaters;
  EXPECT_EQ(find_removal(cloud, {}, floaters).going(), 0u);
  floaters.least_opacity = 0.6f;
  EXPECT_EQ(find_removal(cloud, {}, floaters).marks[half], Removed::faint);
  floaters.largest_size = 0.1f;
  EXPECT_EQ(find_removal(cloud, {}, floaters).marks[wide], Removed::large);
  EXPECT_EQ(find_removal(cloud, {}, floaters).going(), 2u);
  floaters.fewest_neighbours = 1'000'000;
  EXPECT_EQ(find_removal(cloud, {}, floaters).going(), cloud.size());
}

TEST(Removal, a_small_clump_needs_as_many_neighbours_as_the_limit) {
  for (const int members : {3, 6, 7, 8}) {
    GaussianCloud cloud = table();
    for (int i = 0; i < members; ++i)
      plant(cloud, {0.01f * static_cast<float>(i), -3, 5}, 0.05f, 0.9f);
    Floaters floaters;
    floaters.fewest_neighbours = 6;
    const std::size_t going = find_removal(cloud, {}, floaters).going();
    EXPECT_EQ(going, members - 1 < 6 ? static_cast<std::size_t>(members) : 0u) << members;
  }
}

TEST(Removal, large_gaussians_of_a_background_are_neighbours_over_their_own_size) {
  GaussianCloud cloud = table();
  const std::size_t near = cloud.size();
  SceneBuilder sky(8);
  sky.rectangle(400, {0, -3, 40}, {20, 0, 0}, {0, 20, 0});  // 2 units from one to the next
  append(cloud, sky.cloud);
  ASSERT_GT(cloud.size(), near);
  Floaters floaters;
  floaters.large = false;
  EXPECT_EQ(find_removal(cloud, {}, floaters).going(), 0u);
}

TEST(Removal, floaters_are_searched_inside_of_the_box) {
  GaussianCloud cloud = table();
  const std::uint32_t lone = plant(cloud, {0, -3, 5}, 0.05f, 0.9f);
  for (int i = 0; i < 20; ++i)
    plant(cloud, {0.09f, -3 + 0.001f * static_cast<float>(i), 5}, 0.05f, 0.9f);
  EXPECT_EQ(find_removal(cloud, {}, Floaters()).marks[lone], Removed::no);
  const Removal removal = find_removal(cloud, CropBox{{-4, -4, 0}, {0.08f, 4, 9}}, Floaters());
  EXPECT_EQ(removal.marks[lone], Removed::isolated);
  EXPECT_EQ(removal.marks[lone + 1], Removed::outside);
  expect_consistent(removal);
}

TEST(Removal, values_that_are_no_numbers_go_and_disturb_nothing) {
  GaussianCloud cloud = table();
  const std::uint32_t first = plant(cloud, {kNan, 0, 5}, 0.05f, 0.9f);
  plant(cloud, {0, kInf, 5}, 0.05f, 0.9f);
  plant(cloud, {0, 0, 5}, 0.05f, 0.9f);
  cloud.opacity_logits.back() = kNan;
  plant(cloud, {0, 0, 5}, 0.05f, 0.9f);
  cloud.log_scales.back().y = kNan;
  plant(cloud, {0, 0, 5}, 0.05f, 0.9f);
  cloud.log_scales.back() = glm::vec3(-kInf);  // a point
  const Removal removal = find_removal(cloud, {}, Floaters());
  EXPECT_EQ(removal.marks[first], Removed::isolated);
  EXPECT_EQ(removal.marks[first + 1], Removed::isolated);
  EXPECT_EQ(removal.marks[first + 2], Removed::faint);
  EXPECT_EQ(removal.marks[first + 3], Removed::large);
  EXPECT_EQ(removal.marks[first + 4], Removed::no);
  EXPECT_EQ(removal.going(), 4u);
  const Removal boxed = find_removal(cloud, CropBox{glm::vec3(-99), glm::vec3(99)}, {});
  EXPECT_EQ(boxed.marks[first], Removed::outside);
  EXPECT_EQ(boxed.going(), 2u);
}

TEST(Removal, clouds_of_nothing_and_of_one_place_are_answered) {
  EXPECT_EQ(find_removal({}, CropBox{}, Floaters()).all(), 0u);
  GaussianCloud cloud = random_cloud(50, 0, 1);
  for (glm::vec3& position : cloud.positions) position = {1, 2, 3};
  for (float& logit : cloud.opacity_logits) logit = 2;
  EXPECT_EQ(find_removal(cloud, {}, Floaters()).going(), 0u);
  for (glm::vec3& position : cloud.positions) position = glm::vec3(kNan);
  EXPECT_EQ(find_removal(cloud, {}, Floaters()).going(), 50u);
}

TEST(Removal, the_order_of_the_gaussians_changes_nothing) {
  GaussianCloud cloud = table();
  append(cloud, surrounding_cloud(500, 0, 4));
  const auto order = morton_order(cloud);
  const Removal removal = find_removal(cloud, {}, Floaters());
  const Removal turned = find_removal(select(cloud, order), {}, Floaters());
  EXPECT_GT(removal.going(), 0u);
  for (std::size_t i = 0; i < order.size(); ++i)
    ASSERT_EQ(turned.marks[i], removal.marks[order[i]]) << i;
}

}  // namespace
}  // namespace qs::test
