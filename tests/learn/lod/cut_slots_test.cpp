// SPDX-License-Identifier: MIT
//
// The cuts of a flight in the slots of one cloud, against the clouds of the cuts alone.
#include "learn/lod/cut_slots.h"

#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/cloud/cloud_memory.h"
#include "learn/lod/cut.h"
#include "support/pool.h"
#include "support/random_tree.h"

namespace qs::test {
namespace {

class CutSlotsTest : public testing::Test {
 protected:
  CutSlotsTest() : tree_(random_tree(6000, 512, 3)) {
    tree_.footprint = 1e-4f;
    for (auto& page : tree_.pages) {
      auto own = std::make_shared<LodPage>(*page);
      for (std::size_t i = 0; i < own->nodes.size(); ++i) {
        own->nodes[i].layers = 0.5f;
        own->nodes[i].opacities = static_cast<float>(1 + i % 7);
        own->cloud.log_scales[i] = glm::vec3(-5);
      }
      page = own;
    }
  }

  // Nodes are side by side along x, so the camera's place decides the nodes in its picture.
  static LodView view_at(double x) {
    Camera camera;
    camera.view_from_world[3] = {-x, 0, 3};
    camera.focal_px = {80, 80};
    camera.center_px = {49.5, 49.5};
    camera.width = camera.height = 100;
    return {camera, 0.01f};
  }

  StreamedCut cut_at(const LodView& view, std::size_t budget) {
    const LodGain gain = [&](const LodPage& page, std::size_t row) {
      const LodSight sight = view(page.cloud.positions[row], 0.1f);
      return sight.share * page.nodes[row].radius / sight.footprint;
    };
    return {tree_, cut_of(tree_, gain, {budget}, pool())};
  }

  void follow(double x, std::size_t budget, bool exact, double dilation = 0.3) {
    const LodView view = view_at(x);
    const StreamedCut made = cut_at(view, budget);
    expected_ = cut_cloud(made.tree, made.cut, view, dilation, pool());
    CutChange change = slots_.follow(made, view, dilation, exact, pool());
    is_whole_ = change.whole != nullptr;
    if (is_whole_) {
      EXPECT_THAT(change.parts, testing::IsEmpty());
      cloud_ = std::move(*change.whole);
      drawn_ = std::move(change.drawn);
    }
    const std::size_t most = std::max(drawn_.count(), made.cut.count);
    changed_ = 0;
    parts_ = change.parts.size();
    for (const CutPart& part : change.parts) {
      changed_ += part.slots.size();
      ASSERT_EQ(part.gaussians.size(), part.slots.size());
      for (std::size_t k = 0; k < part.slots.size(); ++k)
        copy_gaussian(part.gaussians, k, cloud_, part.slots[k]);
      for (const std::uint32_t slot : part.toggled) drawn_.toggle(slot);
      EXPECT_LE(drawn_.count(), most);
      expect_cover();
    }
    ASSERT_EQ(drawn_.size(), cloud_.size());
    expect_cut();
  }

  // The drawn slots have the Gaussians of the cut, and opacities near theirs.
  void expect_cut() {
    std::map<float, float> logits;  // by x, which no two nodes share
    drawn_.for_each([&](std::size_t slot) {
      EXPECT_TRUE(logits.emplace(cloud_.positions[slot].x, cloud_.opacity_logits[slot]).second);
    });
    ASSERT_EQ(logits.size(), expected_.size());
    for (std::size_t i = 0; i < expected_.size(); ++i) {
      const auto found = logits.find(expected_.positions[i].x);
      ASSERT_NE(found, logits.end()) << i;
      if (found->second != expected_.opacity_logits[i]) ++stale_;
    }
  }

  // The drawn nodes are a cut: exactly one is above each leaf, or is it. Node i of the tree is at
  // i.
  void expect_cover() const {
    std::vector<int> above(tree_.count);
    drawn_.for_each(
        [&](std::size_t slot) { ++above[static_cast<std::size_t>(cloud_.positions[slot].x)]; });
    for (std::size_t i = 0; i < above.size(); ++i) {
      const LodFacts& node = tree_.pages[i / tree_.page_nodes]->nodes[i % tree_.page_nodes];
      if (node.child_count == 0) {
        ASSERT_EQ(above[i], 1) << i;
      }
      for (std::size_t child = 0; child < node.child_count; ++child)
        above[node.first_child + child] += above[i];
    }
  }

  void expect_exact() {
    for (std::size_t i = 0; i < expected_.size(); ++i) {
      ASSERT_TRUE(drawn_[i]);
      EXPECT_EQ(cloud_.positions[i], expected_.positions[i]);
      EXPECT_EQ(cloud_.log_scales[i], expected_.log_scales[i]);
      EXPECT_EQ(cloud_.opacity_logits[i], expected_.opacity_logits[i]);
    }
  }

  LodPages tree_;
  CutSlots slots_;
  GaussianCloud cloud_, expected_;
  GaussianSet drawn_;
  bool is_whole_ = false;
  std::size_t changed_ = 0, stale_ = 0, parts_ = 0;
};

TEST_F(CutSlotsTest, a_flight_changes_only_the_nodes_that_are_new) {
  follow(10, 800, false);
  EXPECT_TRUE(is_whole_);  // the first cut
  expect_exact();
  std::size_t parts = 0;
  for (int step = 1; step < 60; ++step) {
    follow(10 + 37.0 * step, step % 7 == 3 ? 600 : 800, false);
    EXPECT_FALSE(is_whole_) << step;
    EXPECT_LT(changed_, 700u) << step;
    parts += parts_;
  }
  EXPECT_GT(parts, 59u);  // some steps have several
  follow(100, 800, true);
  EXPECT_TRUE(is_whole_);
  expect_exact();
}

TEST_F(CutSlotsTest, opacities_of_nodes_that_stay_follow_the_distance) {
  follow(10, 800, true);
  stale_ = 0;
  follow(10, 800, false, 0.6);  // the filter is twice as wide: all nodes change, in eight turns
  EXPECT_GT(stale_, 30u);
  for (int turn = 0; turn < 8; ++turn) {
    stale_ = 0;
    follow(10, 800, false, 0.6);
  }
  EXPECT_EQ(stale_, 0u);
  follow(10, 800, false, 0.63);  // 1.05 times: not worth a change
  EXPECT_EQ(changed_, 0u);
}

TEST_F(CutSlotsTest, more_nodes_than_slots_are_uploaded_again) {
  follow(10, 100, false);
  follow(10, 1000, false);
  EXPECT_FALSE(is_whole_);
  follow(10, 4000, false);
  EXPECT_TRUE(is_whole_);
  expect_exact();
}

}  // namespace
}  // namespace qs::test
