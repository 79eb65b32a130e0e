// SPDX-License-Identifier: MIT
//
// Cuts of trees against opening one node after the other, with and without all pages.
#include "raster/pages/cut.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/error_of.h"
#include "support/pool.h"
#include "support/random_tree.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

TEST(LodCut, opens_the_largest_gains_that_fit_into_the_budget) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const LodPages tree = random_tree(3000, 128, seed);
    for (const std::size_t budget : {0, 1, 2, 5, 17, 100, 999, 1500, 3000, 4000}) {
      for (const float limit : {0.0f, 0.01f, 0.5f, 0.9f, 5.0f}) {
        const LodCut cut = cut_of(tree, gain_of_scale, {budget, limit}, pool());
        EXPECT_EQ(nodes_of(tree, cut),
                  opened_one_by_one(tree, {std::max<std::size_t>(budget, 1), limit}))
            << seed << " " << budget << " " << limit;
        EXPECT_EQ(cut.count, nodes_of(tree, cut).size());
        EXPECT_THAT(cut.missing, IsEmpty());
      }
    }
  }
}

TEST(LodCut, depends_neither_on_threads_nor_on_the_guess) {
  const LodPages tree = random_tree(20000, 512, 4);
  const auto expected = nodes_of(tree, cut_of(tree, gain_of_scale, {4000}, pool(1)));
  for (const int threads : {2, 3, 7})
    for (const float guess : {0.0f, 1e-6f, 0.3f, 0.7f, 100.0f})
      EXPECT_EQ(nodes_of(tree, cut_of(tree, gain_of_scale, {4000}, pool(threads), guess)), expected)
          << threads << " " << guess;
}

TEST(LodCut, without_limits_is_all_leaves_even_if_gains_are_0) {
  const LodPages tree = random_tree(2000, 256, 5);
  const LodCut cut = cut_of(
      tree, [](const LodPage&, std::size_t) { return 0.0f; }, {kAll, 0}, pool());
  std::vector<std::uint64_t> leaves;
  for (std::uint64_t i = 0; i < tree.count; ++i)
    if (node_of(tree, i).child_count == 0) leaves.push_back(i);
  EXPECT_EQ(nodes_of(tree, cut), leaves);
  EXPECT_EQ(cut.limit, 0);
}

TEST(LodCut, one_node_is_its_own_cut) {
  const LodPages tree = random_tree(1, 65536, 1);
  for (const std::size_t budget : {std::size_t{0}, std::size_t{1}, kAll})
    EXPECT_THAT(nodes_of(tree, cut_of(tree, gain_of_scale, {budget}, pool())), ElementsAre(0));
}

// The number of nodes of the cut at or above each leaf.
std::vector<int> covers(const LodPages& whole, const std::vector<std::uint64_t>& nodes) {
  std::vector<int> above(whole.count, 0), leaves;
  for (const std::uint64_t node : nodes) above[node] = 1;
  for (std::uint64_t i = 1; i < whole.count; ++i) above[i] += above[node_of(whole, i).parent];
  for (std::uint64_t i = 0; i < whole.count; ++i)
    if (node_of(whole, i).child_count == 0) leaves.push_back(above[i]);
  return leaves;
}

TEST(LodCut, covers_every_leaf_once_whatever_pages_are_missing) {
  const LodPages whole = random_tree(4000, 100, 6);
  std::mt19937 random(1);
  for (int round = 0; round < 40; ++round) {
    LodPages tree = whole;
    tree.dead.resize(tree.pages.size());
    for (std::size_t page = 1; page < tree.pages.size(); ++page) {
      if (random() % 4 != 0) continue;
      tree.pages[page] = nullptr;
      tree.dead[page] = random() % 2 == 0;
    }
    for (const std::size_t budget : {std::size_t{1}, std::size_t{60}, std::size_t{900}, kAll}) {
      const LodCut cut = cut_of(tree, gain_of_scale, {budget}, pool());
      EXPECT_THAT(covers(whole, nodes_of(tree, cut)), testing::Each(1));
      EXPECT_LE(cut.count, budget);
      for (const LodPart& part : cut.missing) {
        EXPECT_FALSE(tree.pages[part.page]);
        EXPECT_FALSE(tree.dead[part.page]);
        EXPECT_GE(part.gain, cut.limit);
      }
    }
  }
}

TEST(LodCut, pages_that_come_one_after_the_other_end_in_the_same_cut) {
  const LodPages whole = random_tree(4000, 100, 7);
  LodPages tree = whole;
  std::fill(tree.pages.begin() + 1, tree.pages.end(), nullptr);
  LodCut cut = cut_of(tree, gain_of_scale, {700}, pool());
  std::size_t read = 0;
  for (; !cut.missing.empty(); cut = cut_of(tree, gain_of_scale, {700}, pool()), ++read)
    tree.pages[cut.missing.front().page] = whole.pages[cut.missing.front().page];
  EXPECT_EQ(nodes_of(tree, cut), nodes_of(whole, cut_of(whole, gain_of_scale, {700}, pool())));
  EXPECT_LT(read, tree.pages.size() - 1);
}

TEST(LodCut, survives_gains_that_are_no_numbers) {
  const LodPages tree = random_tree(500, 64, 8);
  for (const float odd : {NAN, INFINITY, -1.0f, -INFINITY})
    for (const std::size_t budget : {std::size_t{1}, std::size_t{100}, kAll}) {
      const LodCut cut = cut_of(
          tree,
          [&](const LodPage& page, std::size_t row) {
            return row % 3 == 0 ? odd : gain_of_scale(page, row);
          },
          {budget}, pool());
      EXPECT_THAT(covers(tree, nodes_of(tree, cut)), testing::Each(1));
      EXPECT_LE(cut.count, budget);
    }
}

TEST(LodCut, refuses_a_node_with_several_parents) {
  // Ten levels of two nodes that have the next two as children: 2^10 ways down.
  auto page = std::make_shared<LodPage>();
  page->nodes.resize(21);
  page->cloud.resize(21, 0);
  for (std::uint32_t i = 0; i < 19; ++i) {
    page->nodes[i].child_count = 2;
    page->nodes[i].first_child = i == 0 ? 1 : (i + 1) / 2 * 2 + 1;
    page->nodes[i].radius = 1;
  }
  const LodPages tree{21, 65536, 0, {page}};
  EXPECT_THAT(error_of([&] { cut_of(tree, gain_of_scale, {kAll}, pool()); }, ErrorKind::input),
              HasSubstr("the child of several nodes"));
}

TEST(LodView, sees_the_nearest_point_of_a_ball) {
  Camera camera;  // at 0, looks along z
  camera.focal_px = {100, 400};
  camera.center_px = {49.5, 49.5};
  camera.width = camera.height = 100;
  const LodView view{camera, 0.25f};
  const float focal = 200;  // geometric mean
  struct {
    glm::vec3 center;
    float radius, footprint, share;
  } const rows[] = {
      {{0, 0, 10}, 2, 8 / focal, 1},       {{0, 0, 10}, 0, 10 / focal, 1},
      {{0, 0, 1}, 5, 2e-4f / focal, 1},     // the camera is inside
      {{0, 0, -10}, 2, 8 / focal, 0.25f},   // behind
      {{30, 0, 40}, 1, 49 / focal, 0.25f},  // to the right of the picture
      {{0, 3, 4}, 1, 4 / focal, 0.25f},     // below
      {{20.5f, 0, 40}, 2, 38 / focal, 1},   // partly inside
      {{0, 0, 1e9f}, 1, 1e9f / focal, 1},
  };
  for (const auto& row : rows) {
    const LodSight sight = view(row.center, row.radius);
    EXPECT_NEAR(sight.footprint, row.footprint, 1e-5f * row.footprint) << row.center.z;
    EXPECT_EQ(sight.share, row.share) << row.center.x << " " << row.center.z;
  }
}

TEST(LodView, of_a_wide_lens_sees_all_around_up_to_its_angle) {
  Camera camera;  // at 0, looks along z
  camera.focal_px = {50, 50};
  const float right = std::numbers::sqrt2_v<float> / 2;
  struct {
    double angle;
    glm::vec3 center;
    float radius, distance, share;
  } const rows[] = {
      {3.2, {0, 0, -10}, 2, 8, 1},
      {3.2, {0, -3, -4}, 1, 4, 1},
      {1.6, {7, 0, 0}, 0, 7, 1},
      {1.6, {7, 0, -1}, 0.5f, 6.5711f, 0.25f},
      {0.7854, {5, 0, 3}, 1, 4.831f, 0.25f},  // 2 right units outside
      {0.7854, {0, 5, 3}, 2 * right + 0.01f, 4.4067f, 1},
      {2.5, {0, 0, -10}, 1, 9, 0.25f},
      {2.5, {1, 0, -1}, 0, 1.4142f, 1},
  };
  for (const auto& row : rows) {
    const LodSight sight = LodView{camera, 0.25f, {row.angle}}(row.center, row.radius);
    EXPECT_NEAR(sight.footprint, row.distance / 50, 1e-4f * row.distance) << row.angle;
    EXPECT_EQ(sight.share, row.share) << row.angle << " " << row.center.x;
    const LodSight eyes = LodView{camera, 0.25f, {row.angle, 0.1}}(row.center, row.radius);
    EXPECT_NEAR(eyes.footprint, (row.distance - 0.1f) / 50, 1e-4f * row.distance);
  }
}

TEST(LodView, of_parallel_rays_has_one_footprint) {
  Camera camera;  // at 0, looks along z, 8 units wide
  camera.projection = Projection::orthographic;
  camera.focal_px = {25, 25};
  camera.center_px = {99.5, 49.5};
  camera.width = 200, camera.height = 100;
  const LodView view{camera, 0.25f};
  for (const float z : {0.5f, 20.0f, 3000.0f}) {
    EXPECT_EQ(view({3.9f, 1.9f, z}, 0).share, 1);
    EXPECT_EQ(view({4.5f, 0, z}, 0.3f).share, 0.25f);
    EXPECT_EQ(view({4.5f, 0, z}, 0.6f).share, 1);
    EXPECT_EQ(view({0, -2.5f, z}, 0.3f).share, 0.25f);
    EXPECT_FLOAT_EQ(view({0, 0, z}, 0.1f).footprint, 1.0f / 25);
  }
  EXPECT_EQ(view({0, 0, -5}, 1).share, 0.25f);
}

TEST(LodGain, is_interpolated_between_the_footprints) {
  LodNode node;
  node.child_count = 2;
  node.gains = {100, 96, 92, 80, 60, 40, 20, 0};
  const auto value = [](double step) { return std::exp2(step / 4 - 28); };
  EXPECT_NEAR(lod_gain(node, 1, 1) / value(100), 1, 1e-5);
  EXPECT_NEAR(lod_gain(node, 1, 4) * 16 / value(96), 1, 1e-5);
  EXPECT_NEAR(lod_gain(node, 1, 2) * 4 / value(98), 1, 1e-5);
  EXPECT_NEAR(lod_gain(node, 1, 0.5f) * 0.25 / value(100), 1, 1e-5);  // below the smallest
  EXPECT_NEAR(lod_gain(node, 2, 8) * 16 / value(96), 1, 1e-5);
  node.child_count = 0;
  EXPECT_EQ(lod_gain(node, 1, 1), 0);
}

}  // namespace
}  // namespace qs::test
