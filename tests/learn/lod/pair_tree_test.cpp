// SPDX-License-Identifier: MIT
//
// Forests of pairs, their gains against all possible cuts, and cuts of trees.
#include "learn/lod/pair_tree.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "support/lod_errors.h"

namespace qs::test {
namespace {

std::vector<LodGaussian> random_items(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random()) / 4294967296.0f;
  };
  std::vector<LodGaussian> items(count);
  for (LodGaussian& item : items) {
    item.mean = {uniform(-1, 1), uniform(-1, 1), uniform(-0.1f, 0.1f)};
    const float s = std::exp2(uniform(-8, -3));
    item.covariance = {s * s, 0, 0, s * s, 0, s * s / 16};
    for (float& value : item.color) value = uniform(-0.3f, 0.3f);
    set_opacity(item, uniform(0.05f, 1));
  }
  return items;
}

void expect_forest(const PairForest& forest, std::size_t items, std::size_t roots) {
  ASSERT_EQ(forest.items, items);
  ASSERT_EQ(forest.roots.size(), std::min(items, roots));
  ASSERT_EQ(forest.nodes.size(), 2 * items - forest.roots.size());
  std::vector<int> parents(forest.nodes.size(), 0);
  for (std::size_t i = 0; i < forest.children.size(); ++i)
    for (const std::uint32_t child : forest.children[i]) {
      EXPECT_LT(child, items + i);
      ++parents[child];
    }
  for (const std::uint32_t root : forest.roots) parents[root] += 1;
  for (const int count : parents) EXPECT_EQ(count, 1);
}

TEST(PairTree, every_node_has_one_parent_or_is_a_root) {
  for (const auto& [items, roots] : std::vector<std::pair<std::size_t, std::size_t>>{
           {1, 1}, {2, 1}, {2, 2}, {3, 1}, {3, 5}, {100, 1}, {100, 7}, {1000, 4}})
    expect_forest(merge_pairs(random_items(items, 5), roots, false), items, roots);
}

TEST(PairTree, equal_items_at_one_place_make_a_tree) {
  const std::vector<LodGaussian> items(200, random_items(1, 3)[0]);
  const PairForest forest = merge_pairs(items, 1, false);
  expect_forest(forest, 200, 1);
  EXPECT_NEAR(forest.nodes.back().mass / (200 * items[0].mass), 1, 1e-4);
}

TEST(PairTree, items_that_show_nothing_or_have_no_size_make_a_tree) {
  std::vector<LodGaussian> items = random_items(60, 4);
  for (std::size_t i = 0; i < 40; ++i) {
    if (i % 2 == 0) items[i].covariance = {};
    set_opacity(items[i], i % 3 == 0 ? 0 : 0.5f);
  }
  expect_forest(merge_pairs(items, 1, true), 60, 1);
}

TEST(PairTree, near_pairs_of_one_colour_merge_first) {
  // Pairs of one colour at distances far above the distance within a pair.
  std::vector<LodGaussian> items;
  for (int i = 0; i < 40; ++i) {
    LodGaussian item;
    item.mean = {static_cast<float>(i / 2), static_cast<float>(i % 2) * 0.01f, 0};
    item.covariance = {1e-4f, 0, 0, 1e-4f, 0, 1e-4f};
    item.color = {i / 2 % 2 == 0 ? 0.4f : -0.4f};
    set_opacity(item, 0.8f);
    items.push_back(item);
  }
  const PairForest forest = merge_pairs(items, 20, false);
  for (const auto& [a, b] : forest.children) EXPECT_EQ(a / 2, b / 2);
}

TEST(PairTree, gains_fall_from_parents_to_children_and_with_the_footprint) {
  const PairForest forest = merge_pairs(random_items(500, 8), 3, false);
  const auto levels = levels_of(forest, std::vector<NodeLevels>(500), 1e-3f, false);
  for (std::size_t i = 500; i < forest.nodes.size(); ++i) {
    for (const std::uint32_t child : forest.children[i - 500]) {
      EXPECT_LE(glm::length(forest.nodes[child].mean - forest.nodes[i].mean) + levels[child].radius,
                levels[i].radius * 1.0001f);
      for (std::size_t k = 0; k < kLodFootprints; ++k) {
        EXPECT_GE(levels[i].gains[k], levels[child].gains[k]);
        EXPECT_GE(levels[i].errors[k], levels[child].errors[k]);
      }
    }
    for (std::size_t k = 1; k < kLodFootprints; ++k)
      EXPECT_LE(levels[i].gains[k], levels[i].gains[k - 1] + kLodStepsOfFootprint);
  }
}

TEST(PairTree, errors_of_nodes_below_a_pixel_count_less) {
  // At 4^7 times the first footprint all nodes are far smaller than a pixel.
  const std::vector<LodGaussian> items = random_items(2, 6);
  const PairForest forest = merge_pairs(items, 1, false);
  const auto levels = levels_of(forest, std::vector<NodeLevels>(2), 1e-2f, false);
  for (const std::size_t k : {std::size_t{0}, kLodFootprints - 1}) {
    const float side = lod_footprint(1e-2f, k), v = 0.3f * side * side;
    const LodCovariance& c = forest.nodes[2].covariance;
    const float size = (c[0] + c[3] + c[5]) / 2;
    EXPECT_NEAR(levels[2].errors[k] / merging_error(items[0], items[1], v, false),
                size / (size + v), 1e-4);
  }
}

// All cuts of a subtree: number of nodes -> least error, as lists of the open nodes.
using Cuts = std::map<std::size_t, double>;
Cuts all_cuts(const PairForest& forest, const std::vector<double>& own, std::uint32_t node) {
  double whole = 0;
  const std::function<void(std::uint32_t)> sum = [&](std::uint32_t i) {
    if (i < forest.items) return;
    whole += own[i];
    for (const std::uint32_t child : forest.children[i - forest.items]) sum(child);
  };
  sum(node);
  Cuts cuts{{1, whole}};
  if (node < forest.items) return cuts;
  const auto [a, b] = forest.children[node - forest.items];
  for (const auto& [na, ea] : all_cuts(forest, own, a))
    for (const auto& [nb, eb] : all_cuts(forest, own, b)) {
      const auto [at, is_new] = cuts.emplace(na + nb, ea + eb);
      if (!is_new) at->second = std::min(at->second, ea + eb);
    }
  return cuts;
}

TEST(PairTree, cuts_by_gain_are_on_the_lower_hull_of_all_cuts) {
  constexpr float kFootprint = 0.02f;
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u}) {
    constexpr std::size_t kItems = 14;
    const PairForest forest = merge_pairs(random_items(kItems, seed), 1, false);
    const auto levels = levels_of(forest, std::vector<NodeLevels>(kItems), kFootprint, false);
    std::vector<double> own(forest.nodes.size());
    for (std::size_t i = kItems; i < own.size(); ++i) {
      const auto [a, b] = forest.children[i - kItems];
      constexpr float kFilter = 0.3f * kFootprint * kFootprint;
      const LodCovariance& c = forest.nodes[i].covariance;
      const float size = (c[0] + c[3] + c[5]) / 2;  // the share of nodes below a pixel
      own[i] = static_cast<double>(merging_error(forest.nodes[a], forest.nodes[b], kFilter, false) *
                                   size / (size + kFilter));
    }
    const Cuts best = all_cuts(forest, own, forest.roots[0]);
    std::set<int> limits;
    for (const NodeLevels& level : levels) limits.insert(level.gains[0]);
    for (const int limit : limits) {
      // Collapse what gains at most the limit; count nodes and error of this cut.
      std::size_t count = kItems;
      double error = 0;
      for (std::size_t i = kItems; i < own.size(); ++i)
        if (levels[i].gains[0] <= limit) {
          --count;
          error += own[i];
        }
      // No mixture of two cuts with this number of nodes is better, but by the rounding of steps.
      for (const auto& [na, ea] : best)
        for (const auto& [nb, eb] : best) {
          if (na > count || nb <= count) continue;
          const double part = static_cast<double>(count - na) / static_cast<double>(nb - na);
          EXPECT_LE(error, (ea + (eb - ea) * part) * 1.2 + 1e-9) << seed << " " << count;
        }
    }
  }
}

TEST(PairTree, the_flat_forest_has_all_items_once) {
  const PairForest forest = merge_pairs(random_items(800, 9), 5, false);
  const auto levels = levels_of(forest, std::vector<NodeLevels>(800), 1e-3f, false);
  const FlatForest flat = flattened(forest, levels);
  EXPECT_LT(flat.nodes.size(), forest.nodes.size());
  std::vector<int> seen(forest.nodes.size(), 0), is_child(flat.nodes.size(), 0);
  for (std::uint32_t i = 0; i < flat.nodes.size(); ++i) {
    const FlatForest::Node& node = flat.nodes[i];
    ++seen[node.number];
    EXPECT_EQ(node.number < 800, node.child_count == 0);
    if (node.child_count == 0) continue;
    EXPECT_GT(node.first_child, i);
    EXPECT_GE(node.child_count, 2u);
    for (std::uint32_t child = 0; child < node.child_count; ++child) {
      EXPECT_EQ(flat.nodes[node.first_child + child].parent, i);
      ++is_child[node.first_child + child];
    }
  }
  for (std::size_t i = 0; i < flat.nodes.size(); ++i) EXPECT_EQ(is_child[i], i < 5 ? 0 : 1);
  for (std::size_t i = 0; i < 800; ++i) EXPECT_EQ(seen[i], 1);
}

// Nodes with large gains come first; below them, a page has one part of the scene.
TEST(PairTree, a_part_of_the_scene_is_in_few_pages) {
  constexpr std::size_t kItems = 120'000;
  const PairForest forest = merge_pairs(random_items(kItems, 3), 500, false);
  const auto levels = levels_of(forest, std::vector<NodeLevels>(kItems), 1e-3f, false);
  const FlatForest flat = flattened(forest, levels);
  constexpr std::uint32_t kPage = 65536, kLayer = kPage / 4;
  const auto last_page = static_cast<std::uint32_t>((flat.nodes.size() - 1) / kPage);
  ASSERT_GE(last_page, 2u);
  int least_above = 1 << 20, most_below = 0;
  std::vector<std::uint32_t> root(flat.nodes.size());
  std::vector<std::set<std::uint32_t>> pages(500);
  for (std::uint32_t i = 0; i < flat.nodes.size(); ++i) {
    root[i] = i < 500 ? i : root[flat.nodes[i].parent];
    pages[root[i]].insert(i / kPage);
    if (i < 500) continue;
    const LodSteps& gains = levels[flat.nodes[flat.nodes[i].parent].number].gains;
    const int sum = std::accumulate(gains.begin(), gains.end(), 0);
    if (i < kLayer) least_above = std::min(least_above, sum);
    if (i > kLayer + 500 + 64) most_below = std::max(most_below, sum);
  }
  EXPECT_GE(least_above, most_below);
  // In order of breadth a tree is in nearly all pages.
  std::size_t sum = 0;
  for (const auto& of_root : pages) sum += of_root.size();
  EXPECT_LT(static_cast<double>(sum) / 500, 0.75 * (last_page + 1));
}

TEST(LodSteps, are_quarters_of_powers_of_two) {
  EXPECT_EQ(lod_step(0, 1), 0);
  EXPECT_EQ(lod_step(NAN, 1), 0);
  EXPECT_EQ(lod_step(1, 1), 4 * 28);
  EXPECT_EQ(lod_step(4, 2), 4 * 28);
  EXPECT_EQ(lod_step(1e30f, 1e-3f), 255);
  for (int step = 1; step < 256; ++step)
    EXPECT_EQ(lod_step(lod_value(static_cast<std::uint8_t>(step), 0.01f), 0.01f), step);
}

}  // namespace
}  // namespace qs::test
