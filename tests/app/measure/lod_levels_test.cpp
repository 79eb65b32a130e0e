// SPDX-License-Identifier: MIT
//
// The levels of detail of `bench --lod`: values by hand, and the rules of every cut.
#include "app/measure/lod_levels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <set>

#include <glm/exponential.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "raster/scene/activated_cloud.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs::test {
namespace {

using testing::ElementsAre;

double opacity(const GaussianCloud& cloud, std::size_t i) {
  return opacity_of_logit(cloud.opacity_logits[i]);
}

double scale(const GaussianCloud& cloud, std::size_t i, int axis) {
  return std::exp(static_cast<double>(cloud.log_scales[i][axis]));
}

float logit(double opacity) { return static_cast<float>(std::log(opacity / (1 - opacity))); }

// A round Gaussian without SH.
GaussianCloud round_gaussian(glm::vec3 position, float sigma, double opacity) {
  return single_gaussian(position, sigma, glm::vec3(0.25f), logit(opacity));
}

const LodPage& page_of(const Octree& octree) { return *octree.tree.pages[0]; }

// The parent of each node, and -1 for the root.
std::vector<int> parents(const Octree& octree) {
  std::vector<int> result(octree.tree.count, -1);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const LodFacts& node = page_of(octree).nodes[i];
    for (std::size_t k = 0; k < node.child_count; ++k)
      result[node.first_child + k] = static_cast<int>(i);
  }
  return result;
}

LodGain by_order(const Octree& octree) {
  return [&octree](const LodPage&, std::size_t row) { return octree.order[row]; };
}

std::vector<std::uint32_t> rows(const LodCut& cut) {
  std::vector<std::uint32_t> result;
  cut.parts.at(0).for_each(
      [&](std::size_t row) { result.push_back(static_cast<std::uint32_t>(row)); });
  EXPECT_EQ(cut.count, result.size());
  return result;
}

// ---- uniform samples ----------------------------------------------------------------------------

TEST(UniformSample, opacity_times_area_grows_by_what_is_lost) {
  GaussianCloud cloud = random_cloud(400, 2, 7);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.positions[i] = {static_cast<float>(i), 0, 0};  // names the Gaussian
    cloud.opacity_logits[i] = logit(0.002 + 0.98 * static_cast<double>(i) / 400);
  }
  for (const std::size_t count : {1u, 7u, 100u, 399u, 400u}) {
    const GaussianCloud sample = uniform_sample(cloud, count);
    ASSERT_EQ(sample.size(), count);
    const double factor = 400.0 / static_cast<double>(count);
    for (std::size_t k = 0; k < count; ++k) {
      const auto i = static_cast<std::size_t>(sample.positions[k].x);
      const double grown = scale(sample, k, 1) / scale(cloud, i, 1);
      EXPECT_NEAR(opacity(sample, k) * grown * grown / (opacity(cloud, i) * factor), 1, 1e-4);
      EXPECT_LE(opacity(sample, k), 0.9901);
      if (grown > 1 + 1e-6) {
        EXPECT_NEAR(opacity(sample, k), 0.99, 1e-5);
      }
    }
  }
  EXPECT_EQ(uniform_sample(cloud, 400).opacity_logits, cloud.opacity_logits);
}

TEST(UniformSample, every_part_of_a_scene_is_sampled_alike) {
  GaussianCloud cloud;
  for (int i = 0; i < 4000; ++i)
    append(cloud, round_gaussian({static_cast<float>(i), 0, 5}, 0.1f, 0.5));
  const GaussianCloud sample = uniform_sample(cloud, 1000);
  std::vector<int> quarters(4);
  for (const glm::vec3& p : sample.positions) ++quarters[static_cast<std::size_t>(p.x) / 1000];
  // A share of 1/4 of 1,000 without replacement has a standard deviation of 11.9.
  for (const int quarter : quarters) EXPECT_NEAR(quarter, 250, 60);
}

// ---- the octree ---------------------------------------------------------------------------------

TEST(Octree, two_gaussians_of_a_cell_become_their_mixture) {
  // Cells of 0.25 from -0.001 on: both are in the first, and as large as a cell may merge.
  GaussianCloud cloud = round_gaussian({0, 0, 0}, 0.1f, 0.9);
  append(cloud, round_gaussian({0.2f, 0, 0}, 0.1f, 0.3));
  cloud.sh[0] = {1, 0, 0};
  cloud.sh[1] = {0, 1, 0};
  const Octree tree = octree_of(cloud, pool());
  EXPECT_THAT(parents(tree), ElementsAre(-1, 0, 0));
  EXPECT_THAT(tree.order, ElementsAre(1, 0, 0));
  EXPECT_THAT(page_of(tree).numbers, ElementsAre(kNoNumber, 0, 1));
  const GaussianCloud& nodes = page_of(tree).cloud;
  // Shares 0.75 and 0.25; 0.05 and 0.15 from the mean.
  EXPECT_NEAR(nodes.positions[0].x, 0.05, 1e-6);
  const double spread = 0.75 * 0.05 * 0.05 + 0.25 * 0.15 * 0.15;
  const auto c = world_covariance(nodes, 0);
  EXPECT_NEAR(c.xx, 0.01 + spread, 1e-7);
  EXPECT_NEAR(c.yy, 0.01, 1e-8);
  EXPECT_NEAR(c.zz, 0.01, 1e-8);
  EXPECT_NEAR(nodes.sh[0].x, 0.75, 1e-6);
  EXPECT_NEAR(nodes.sh[0].y, 0.25, 1e-6);
  // Thomsen's area of the ellipsoid, relative to the sphere's.
  const double p = 1.6075, long_axis = std::sqrt(0.01 + spread);
  const double area = std::pow((2 * std::pow(long_axis * 0.1, p) + std::pow(0.01, p)) / 3, 1 / p);
  EXPECT_NEAR(opacity(nodes, 0), std::min(0.99, (0.9 + 0.3) * 0.01 / area), 1e-5);
}

TEST(Octree, large_gaussians_wait_for_large_cells) {
  GaussianCloud cloud = round_gaussian({0, 0, 0}, 0.01f, 0.5);
  append(cloud, round_gaussian({0.001f, 0, 0}, 0.01f, 0.5));
  append(cloud, round_gaussian({0.002f, 0, 0}, 1, 0.5));
  const Octree tree = octree_of(cloud, pool());
  EXPECT_THAT(parents(tree), ElementsAre(-1, 0, 0, 2, 2));
  EXPECT_THAT(page_of(tree).numbers, ElementsAre(kNoNumber, 2, kNoNumber, 0, 1));
  EXPECT_THAT(tree.order, ElementsAre(2, 0, 1, 0, 0));
}

TEST(Octree, a_merge_has_at_most_as_many_children_as_a_node_can_count) {
  GaussianCloud cloud;
  cloud.resize(70'000, 0);
  std::ranges::fill(cloud.rotations, glm::quat(1, 0, 0, 0));
  const Octree tree = octree_of(cloud, pool());
  EXPECT_EQ(tree.tree.count, 70'003u);
  EXPECT_EQ(cut_of(tree.tree, by_order(tree), {}, pool()).count, 70'000u);
}

TEST(Octree, every_scene_ends_in_one_root) {
  const float far = 1e19f;
  GaussianCloud odd = round_gaussian({0, 0, 0}, 0, 0);
  odd.log_scales[0] = glm::vec3(-INFINITY);
  append(odd, round_gaussian({far, -far, far}, 1e17f, 0.5));
  append(odd, round_gaussian({0, 0, 0}, 0.1f, 0.5));
  odd.opacity_logits[2] = -INFINITY;
  append(odd, odd);
  for (const GaussianCloud& cloud : {odd, random_cloud(1, 0, 1), random_cloud(2, 3, 2),
                                     random_cloud(3000, 1, 3), surrounding_cloud(1000, 0, 4)}) {
    const Octree tree = octree_of(cloud, pool());
    const LodPage& page = page_of(tree);
    EXPECT_EQ(page.cloud.size(), tree.tree.count);
    const std::vector<int> above = parents(tree);
    EXPECT_EQ(std::ranges::count(above, -1), 1);
    for (std::size_t i = 0; i < above.size(); ++i) EXPECT_LT(above[i], static_cast<int>(i));
    std::set<std::uint32_t> leaves;
    for (std::size_t i = 0; i < above.size(); ++i) {
      EXPECT_TRUE(is_finite(page.cloud.positions[i])) << i;
      EXPECT_FALSE(std::isnan(page.cloud.opacity_logits[i])) << i;
      if (page.nodes[i].child_count > 0) continue;
      leaves.insert(page.numbers[i]);
      EXPECT_EQ(page.cloud.positions[i], cloud.positions[page.numbers[i]]);
    }
    EXPECT_EQ(leaves.size(), cloud.size());
  }
}

TEST(Octree, threads_do_not_change_it) {
  const GaussianCloud cloud = random_cloud(5000, 1, 9);
  ThreadPool one(1), four(4);
  const Octree a = octree_of(cloud, one), b = octree_of(cloud, four);
  EXPECT_EQ(a.order, b.order);
  EXPECT_EQ(page_of(a).numbers, page_of(b).numbers);
  EXPECT_EQ(page_of(a).cloud.positions, page_of(b).cloud.positions);
  EXPECT_EQ(page_of(a).cloud.opacity_logits, page_of(b).cloud.opacity_logits);
  EXPECT_EQ(page_of(a).cloud.sh, page_of(b).cloud.sh);
}

// ---- cuts ---------------------------------------------------------------------------------------

TEST(Cut, the_merges_of_an_octree_come_one_by_one) {
  const Octree tree = octree_of(random_cloud(2000, 0, 5), pool());
  for (const std::size_t budget : {500u, 1000u, 1990u}) {
    const LodCut cut = cut_of(tree.tree, by_order(tree), {budget}, pool());
    EXPECT_LE(cut.count, budget);
    // One merge less would be too many: its cell has at most this many members more.
    const std::vector<std::uint32_t> drawn = rows(cut);
    const auto last =
        *std::ranges::max_element(drawn, {}, [&](std::uint32_t row) { return tree.order[row]; });
    EXPECT_GT(cut.count + page_of(tree).nodes[last].child_count - 1, budget);
  }
}

TEST(Cut, all_nodes_of_the_pages_have_their_order) {
  LodPages tree{5, 2, 0, {}};
  for (const int count : {2, 2, 1}) {
    auto page = std::make_shared<LodPage>();
    for (int i = 0; i < count; ++i)
      append(page->cloud,
             round_gaussian({2 * static_cast<int>(tree.pages.size()) + i, 0, 5}, 0.1f, 0.5));
    page->cloud.origin = {7, 8, 9};
    tree.pages.push_back(page);
  }
  const GaussianCloud all = all_nodes(tree);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(all.positions[i].x, static_cast<float>(i));
  EXPECT_EQ(all.origin, glm::dvec3(7, 8, 9));
}

TEST(Cut, nodes_out_of_view_cost_nothing_and_are_left_out) {
  //      0
  //    1   2
  //   3 4 5 6
  LodPage page;
  page.nodes.resize(7);
  for (const std::uint32_t parent : {0u, 1u, 2u}) {
    page.nodes[parent].first_child = 2 * parent + 1;
    page.nodes[parent].child_count = 2;
  }
  const LodPages tree{7, 7, 0, {std::make_shared<const LodPage>(page)}};
  const LodGain gain = [](const LodPage&, std::size_t row) {
    return std::array{9.0f, 4.0f, 2.0f}[row];
  };
  const auto cut = [&](std::size_t budget, const std::vector<bool>& in_view) {
    return rows(cut_in_view(tree, gain, budget, in_view, pool()));
  };
  const std::vector<bool> left{true, true, false, true, true, false, false};
  EXPECT_THAT(cut(1, left), ElementsAre(1));
  EXPECT_THAT(cut(2, left), ElementsAre(3, 4));
  EXPECT_THAT(cut(2, std::vector<bool>(7, true)), ElementsAre(1, 2));
  EXPECT_THAT(cut(3, std::vector<bool>(7, true)), ElementsAre(2, 3, 4));
  EXPECT_THAT(cut(2, std::vector<bool>(7, false)), testing::IsEmpty());
}

// ---- the rule of distance -----------------------------------------------------------------------

TEST(GainByDistance, is_the_longest_axis_in_pixels) {
  LodPage page;
  page.cloud = round_gaussian({0, 0, 10}, 0.5f, 0.5);
  append(page.cloud, round_gaussian({0, 0, 0}, 0.5f, 0.5));
  page.cloud.log_scales[0].y = std::log(2.0f);
  Camera near = front_camera(100, 100), far = near;
  near.focal_px = far.focal_px = {80, 90};
  far.view_from_world[3].z = 30;
  const auto gain = [&](const Camera& camera, std::uint32_t row) {
    LodAsked asked{&page, nullptr, row, 0};
    const LodView view(camera, 1);
    gain_by_distance({&view, 1})({&asked, 1});
    return asked.gain;
  };
  // 2 sigma = 4 units at a distance of 10; the camera stands in the other node, so its near plane
  // counts.
  EXPECT_NEAR(gain(near, 0), 90 * 4 / 10.0, 1e-4);
  EXPECT_NEAR(gain(near, 1), 90 * 1 / near.near_depth, 1e-3);
  EXPECT_NEAR(gain(far, 0), 90 * 4 / 40.0, 1e-4);
}

}  // namespace
}  // namespace qs::test
