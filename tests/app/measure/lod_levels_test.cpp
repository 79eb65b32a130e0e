// SPDX-License-Identifier: MIT
//
// The levels of detail of `bench --lod`: values by hand, and the rules of every cut.
#include "app/measure/lod_levels.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <set>

#include <glm/exponential.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/cloud/scene.h"
#include "raster/scene/activated_cloud.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs::test {
namespace {

using testing::Each;
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

NodeTree tree_of(const std::vector<std::uint32_t>& parents) {
  auto nodes = std::make_shared<GaussianCloud>();
  for (std::size_t i = 0; i < parents.size(); ++i)
    append(*nodes, round_gaussian({static_cast<float>(i), 0, 5}, 0.1f, 0.5));
  return {nodes, parents};
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
  const GaussianCloud cloud = *tree_of(std::vector<std::uint32_t>(4000, kNoParent)).nodes;
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
  const NodeTree tree = octree_of(cloud, pool());
  EXPECT_THAT(tree.parents, ElementsAre(2, 2, kNoParent));
  const GaussianCloud& nodes = *tree.nodes;
  // Shares 0.75 and 0.25; 0.05 and 0.15 from the mean.
  EXPECT_NEAR(nodes.positions[2].x, 0.05, 1e-6);
  const double spread = 0.75 * 0.05 * 0.05 + 0.25 * 0.15 * 0.15;
  const auto c = world_covariance(nodes, 2);
  EXPECT_NEAR(c.xx, 0.01 + spread, 1e-7);
  EXPECT_NEAR(c.yy, 0.01, 1e-8);
  EXPECT_NEAR(c.zz, 0.01, 1e-8);
  EXPECT_NEAR(nodes.sh[2].x, 0.75, 1e-6);
  EXPECT_NEAR(nodes.sh[2].y, 0.25, 1e-6);
  // Thomsen's area of the ellipsoid, relative to the sphere's.
  const double p = 1.6075, long_axis = std::sqrt(0.01 + spread);
  const double area = std::pow((2 * std::pow(long_axis * 0.1, p) + std::pow(0.01, p)) / 3, 1 / p);
  EXPECT_NEAR(opacity(nodes, 2), std::min(0.99, (0.9 + 0.3) * 0.01 / area), 1e-5);
}

TEST(Octree, large_gaussians_wait_for_large_cells) {
  GaussianCloud cloud = round_gaussian({0, 0, 0}, 0.01f, 0.5);
  append(cloud, round_gaussian({0.001f, 0, 0}, 0.01f, 0.5));
  append(cloud, round_gaussian({0.002f, 0, 0}, 1, 0.5));
  EXPECT_THAT(octree_of(cloud, pool()).parents, ElementsAre(3, 3, 4, 4, kNoParent));
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
    const NodeTree tree = octree_of(cloud, pool());
    EXPECT_EQ(std::ranges::count(tree.parents, kNoParent), 1);
    EXPECT_EQ(tree.parents.back(), kNoParent);
    EXPECT_EQ(tree.nodes->size(), tree.parents.size());
    for (std::size_t i = 0; i + 1 < tree.parents.size(); ++i) {
      EXPECT_GT(tree.parents[i], i);
      EXPECT_GE(tree.parents[i], cloud.size());
    }
    for (std::size_t i = 0; i < cloud.size(); ++i)
      EXPECT_EQ(tree.nodes->positions[i], cloud.positions[i]);
    for (std::size_t i = cloud.size(); i < tree.nodes->size(); ++i) {
      EXPECT_TRUE(is_finite(tree.nodes->positions[i])) << i;
      EXPECT_FALSE(std::isnan(tree.nodes->opacity_logits[i])) << i;
    }
  }
}

TEST(Octree, threads_do_not_change_it) {
  const GaussianCloud cloud = random_cloud(5000, 1, 9);
  ThreadPool one(1), four(4);
  const NodeTree a = octree_of(cloud, one), b = octree_of(cloud, four);
  EXPECT_EQ(a.parents, b.parents);
  EXPECT_EQ(a.nodes->positions, b.nodes->positions);
  EXPECT_EQ(a.nodes->opacity_logits, b.nodes->opacity_logits);
  EXPECT_EQ(a.nodes->sh, b.nodes->sh);
}

// ---- cuts ---------------------------------------------------------------------------------------

// Nodes of the cut above each leaf, the leaf included.
std::vector<int> covers(const NodeTree& tree, const std::vector<std::uint32_t>& cut) {
  const std::set<std::uint32_t> drawn(cut.begin(), cut.end());
  std::vector<int> result;
  for (std::uint32_t i = 0; i < tree.parents.size(); ++i) {
    if (std::ranges::count(tree.parents, i) > 0) continue;
    result.push_back(0);
    for (std::uint32_t node = i; node != kNoParent; node = tree.parents[node])
      result.back() += static_cast<int>(drawn.count(node));
  }
  return result;
}

TEST(Cut, every_leaf_is_drawn_once_within_the_budget) {
  const GaussianCloud cloud = random_cloud(2000, 0, 5);
  const NodeTree tree = octree_of(cloud, pool());
  const Camera camera = front_camera(64, 48);
  for (const std::vector<double>& errors : {tree.order, pixel_sizes(tree, {&camera, 1})}) {
    std::size_t before = 0;
    for (const std::size_t budget : {1u, 2u, 50u, 100u, 777u, 1500u, 1999u, 2000u}) {
      const std::vector<std::uint32_t> cut = cut_of(tree, errors, budget);
      EXPECT_LE(cut.size(), budget);
      EXPECT_GE(cut.size(), before);
      EXPECT_THAT(covers(tree, cut), Each(1)) << budget;
      before = cut.size();
    }
    EXPECT_EQ(before, 2000u);
    EXPECT_THAT(cut_of(tree, errors, 1), ElementsAre(tree.parents.size() - 1));
  }
}

TEST(Cut, the_merges_of_an_octree_come_one_by_one) {
  const NodeTree tree = octree_of(random_cloud(2000, 0, 5), pool());
  for (const std::size_t budget : {500u, 1000u, 1990u}) {
    const std::vector<std::uint32_t> cut = cut_of(tree, tree.order, budget);
    // One merge less would be too many: its cell has at most this many members more.
    const std::size_t last = *std::ranges::max_element(cut);
    const auto members = static_cast<std::size_t>(
        std::ranges::count(tree.parents, static_cast<std::uint32_t>(last)));
    EXPECT_GT(cut.size() + members - 1, budget);
  }
}

TEST(Cut, the_order_of_parents_and_children_does_not_matter) {
  //        0            root first, and the same tree root last
  //      1   2
  //     3 4 5 6
  const NodeTree down = tree_of({kNoParent, 0, 0, 1, 1, 2, 2});
  const NodeTree up = tree_of({4, 4, 5, 5, 6, 6, kNoParent});
  EXPECT_THAT(cut_of(down, std::vector<double>{9, 4, 2, 0, 0, 0, 0}, 3), ElementsAre(2, 3, 4));
  EXPECT_THAT(cut_of(up, std::vector<double>{0, 0, 0, 0, 4, 2, 9}, 3), ElementsAre(0, 1, 5));
}

TEST(Cut, a_child_with_a_larger_error_than_its_parent_is_not_drawn_before_it) {
  const NodeTree tree = tree_of({kNoParent, 0, 0, 1, 1});
  // Node 0 is refined below 3, and node 1 at once with it.
  EXPECT_THAT(cut_of(tree, std::vector<double>{3, 8, 0, 0, 0}, 2), ElementsAre(0));
  EXPECT_THAT(cut_of(tree, std::vector<double>{3, 8, 0, 0, 0}, 3), ElementsAre(2, 3, 4));
}

TEST(Cut, nodes_out_of_view_cost_nothing_and_are_left_out) {
  const NodeTree tree = tree_of({kNoParent, 0, 0, 1, 1, 2, 2});
  const std::vector<double> errors{9, 4, 2, 0, 0, 0, 0};
  EXPECT_THAT(cut_of(tree, errors, 2, {true, true, false, true, true, false, false}),
              ElementsAre(3, 4));
  EXPECT_THAT(cut_of(tree, errors, 2, std::vector<bool>(7, false)), testing::IsEmpty());
}

TEST(Cut, a_budget_that_no_cut_meets_gives_the_smallest_cut) {
  EXPECT_THAT(cut_of(tree_of({kNoParent, kNoParent}), std::vector<double>{0, 0}, 1),
              ElementsAre(0, 1));
}

// ---- the rule of distance -----------------------------------------------------------------------

TEST(PixelSizes, are_those_of_the_nearest_camera) {
  auto nodes = std::make_shared<GaussianCloud>(round_gaussian({0, 0, 10}, 0.5f, 0.5));
  append(*nodes, round_gaussian({0, 0, 0}, 0.5f, 0.5));
  append(*nodes, round_gaussian({0, 0, 10}, 7, 0.5));
  nodes->log_scales[0].y = std::log(2.0f);
  const NodeTree tree(nodes, {1, kNoParent, 0});
  Camera near = front_camera(100, 100), far = near;
  near.focal_px = {80, 90};
  far.focal_px = {80, 90};
  far.view_from_world[3].z = 30;
  // 2 sigma = 4 units at a distance of 10; the camera stands in the other node, so its near plane
  // counts; leaves have no error.
  const Camera both[] = {far, near};
  EXPECT_THAT(pixel_sizes(tree, both),
              ElementsAre(testing::DoubleNear(90 * 4 / 10.0, 1e-4),
                          testing::DoubleNear(90 * 1 / near.near_depth, 1e-4), 0));
  EXPECT_NEAR(pixel_sizes(tree, {&far, 1})[0], 90 * 4 / 40.0, 1e-4);
}

}  // namespace
}  // namespace qs::test
