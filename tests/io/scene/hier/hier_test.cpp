// SPDX-License-Identifier: MIT
//
// .hier: both layouts written byte by byte, and trees and counts that do not fit.
#include "io/scene/hier/hier.h"

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <glm/gtc/packing.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/parallel.h"
#include "io/bytes/byte_cursor.h"
#include "io/support/limits.h"
#include "support/corpus.h"
#include "support/error_of.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

struct Node {
  int depth, parent, start, leaves, merged, first_child, children;
};

// The root with one merged Gaussian, a leaf, and an inner node with two leaves.
std::vector<Node> sound_tree() {
  return {{0, -1, 0, 0, 1, 1, 2},
          {1, 0, 1, 1, 0, 0, 0},
          {1, 0, 2, 0, 1, 3, 2},
          {2, 2, 3, 1, 0, 0, 0},
          {2, 2, 4, 1, 0, 0, 0}};
}

struct File {
  int count = 5;  // Gaussians; Gaussian i is at x = i
  std::vector<Node> nodes = sound_tree();
  bool halves = false;
  float alpha = 0.75f, y = 0, scale = -1, sh = 0.5f, w = 2;
  int stated_count = count, stated_nodes = static_cast<int>(nodes.size());
};

std::string bytes_of(const File& file) {
  std::string bytes;
  const auto number = [&](float value) {
    if (file.halves)
      put_values(bytes, glm::packHalf1x16(value));
    else
      put_values(bytes, value);
  };
  put_values(bytes, file.halves ? -file.stated_count : file.stated_count);
  for (int i = 0; i < file.count; ++i) put_values(bytes, static_cast<float>(i), file.y, -1.f);
  for (int i = 0; i < file.count; ++i)
    for (const float value : {file.w, 0.f, 0.f, 2.f}) number(value);
  for (int i = 0; i < file.count; ++i)
    for (int axis = 0; axis < 3; ++axis) number(file.scale - static_cast<float>(axis));
  for (int i = 0; i < file.count; ++i) number(file.alpha);
  for (int i = 0; i < file.count; ++i)
    for (int k = 0; k < 48; ++k) number(file.sh * static_cast<float>(k));
  put_values(bytes, file.stated_nodes);
  for (const Node& n : file.nodes) {
    const auto small = [](int value) { return static_cast<std::int16_t>(value); };
    if (file.halves)
      put_values(bytes, n.parent, n.start, n.first_child, small(n.depth), small(n.children),
                 small(n.leaves), small(n.merged));
    else
      put_values(bytes, n.depth, n.parent, n.start, n.leaves, n.merged, n.first_child, n.children);
  }
  for (std::size_t i = 0; i < 8 * file.nodes.size(); ++i) number(1);
  return bytes;
}

Scene read(const std::string& text) {
  Scene scene;
  scene.path = "test.hier";
  ThreadPool pool(2);
  read_hier(to_bytes(text), scene.path, pool, {}, scene);
  return scene;
}

TEST(Hier, leaves_are_read_in_both_layouts) {
  for (const bool halves : {false, true}) {
    File file;
    file.halves = halves;
    const std::string bytes = bytes_of(file);
    EXPECT_TRUE(recognises_hier(to_bytes(bytes), "a"));
    const Scene scene = read(bytes);
    const GaussianCloud& cloud = scene.cloud;
    ASSERT_EQ(cloud.size(), 3u);
    EXPECT_EQ(cloud.positions[0], glm::vec3(1, 0, -1));
    EXPECT_EQ(cloud.positions[2], glm::vec3(4, 0, -1));
    EXPECT_EQ(cloud.log_scales[1], glm::vec3(-1, -2, -3));
    EXPECT_NEAR(cloud.rotations[0].w, std::sqrt(0.5f), 1e-6);
    EXPECT_NEAR(cloud.rotations[0].z, std::sqrt(0.5f), 1e-6);
    EXPECT_FLOAT_EQ(cloud.opacity_logits[0], std::log(3.f));
    EXPECT_EQ(cloud.sh_degree, 3);
    EXPECT_EQ(cloud.sh[0], glm::vec3(0, 0.5f, 1));
    EXPECT_EQ(cloud.sh[15], glm::vec3(22.5f, 23, 23.5f));
    EXPECT_EQ(scene.format, halves ? "hier, halves" : "hier, floats");
    EXPECT_THAT(scene.warnings, IsEmpty());
    EXPECT_EQ(scene.levels, (LevelsOfDetail{.levels = 3, .nodes = 5, .leaves = 3, .merged = 2}));
  }
}

TEST(Hier, unusual_files_are_read_with_a_warning) {
  const struct {
    std::function<void(File&)> change;
    std::string more, warning;
    std::size_t leaves;
  } rows[] = {
      {[](File& f) { f.alpha = 1.5f; }, "", "outside 0 to 1", 3},
      {[](File& f) { f.nodes[0].merged = 0; }, "", "1 Gaussians belong to no node", 3},
      {[](File&) {}, "more", "4 bytes after the boxes were ignored.", 3},
      {[](File& f) { f.nodes[1] = {1, 0, 1, 0, 0, 0, 0}; }, "", "belong to no node", 2},
  };
  for (const auto& row : rows) {
    File file;
    row.change(file);
    const Scene scene = read(bytes_of(file) + row.more);
    EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr(row.warning)));
    EXPECT_EQ(scene.cloud.size(), row.leaves);
  }
}

TEST(Hier, a_node_may_have_several_leaves) {
  File file;
  file.nodes = {{0, -1, 0, 4, 1, 0, 0}};
  file.stated_nodes = 1;
  const Scene scene = read(bytes_of(file));
  EXPECT_EQ(scene.cloud.size(), 4u);
  EXPECT_EQ(scene.cloud.positions[3].x, 3);
}

TEST(Hier, long_chains_are_walked_without_recursion) {
  File file;
  file.count = file.stated_count = 1;
  const int length = 1'000'000;
  file.nodes.clear();
  for (int i = 0; i < length; ++i)
    file.nodes.push_back({i, i - 1, 0, i + 1 == length ? 1 : 0, 0, i + 1, i + 1 == length ? 0 : 1});
  file.stated_nodes = length;
  const Scene scene = read(bytes_of(file));
  EXPECT_EQ(scene.cloud.size(), 1u);
  EXPECT_EQ(scene.levels->levels, 1'000'000u);
}

TEST(Hier, every_claim_that_does_not_fit_has_a_sentence) {
  constexpr int kLeast = std::numeric_limits<int>::min(), kMost = std::numeric_limits<int>::max();
  const struct {
    std::function<void(File&)> change;
    std::string sentence;
  } rows[] = {
      {[](File& f) { f.stated_count = 0; }, "holds no Gaussians"},
      {[](File& f) { f.stated_count = kLeast; }, "cut off: the block of positions"},
      {[](File& f) { f.stated_count = kMost; }, "cut off: the block of positions"},
      {[](File& f) { f.stated_count = 12; }, "cut off: "},
      {[](File& f) { f.stated_nodes = 0; }, "its tree has 0 nodes"},
      {[](File& f) { f.stated_nodes = -1; }, "its tree has -1 nodes"},
      {[](File& f) { f.stated_nodes = 6; }, "cut off: the block of boxes"},
      {[](File& f) { f.stated_nodes = kMost; }, "cut off: the tree"},
      {[](File& f) { f.stated_nodes = 4; },
       "node 2 has 2 children from node 3 on, but its tree has 4"},
      {[](File& f) { f.nodes[0].first_child = 0; }, "the children of node 0 begin with node 0"},
      {[](File& f) { f.nodes[2].first_child = 1; }, "the children of node 2 begin with node 1"},
      {[](File& f) { f.nodes[2].first_child = -3; }, "node 2 has 2 children from node -3 on"},
      {[](File& f) { f.nodes[2].children = -2; }, "node 2 has -2 children"},
      {[](File& f) { f.nodes[2].children = 30000; }, "node 2 has 30000 children"},
      {[](File& f) { f.nodes[1] = {1, 0, 1, 1, 0, 3, 1}; }, "node 3 is the child of two nodes"},
      {[](File& f) { f.nodes[2].children = 1; }, "node 4 of its tree is the child of no node"},
      {[](File& f) { f.nodes[1].start = 5; },
       "node 1 names 1 leaves and 0 merged Gaussians from 5 on of 5"},
      {[](File& f) { f.nodes[1].start = -1; }, "node 1 names 1 leaves"},
      {[](File& f) { f.nodes[1].leaves = -1; }, "node 1 names -1 leaves"},
      {[](File& f) { f.nodes[1].merged = 32767; }, "node 1 names 1 leaves and 32767 merged"},
      {[](File& f) { f.nodes[3].start = 1; }, "Gaussian 1 belongs to two nodes"},
      {[](File& f) { f.nodes[0].leaves = 2; }, "Gaussian 1 belongs to two nodes"},
      {[](File& f) { f.y = NAN; }, "every one of its 3 Gaussians has a position"},
      {[](File& f) { f.w = NAN; }, "every one of its 3 Gaussians has a rotation"},
      {[](File& f) { f.alpha = NAN; }, "every one of its 3 Gaussians has an opacity"},
      {[](File& f) { f.sh = INFINITY; }, "every one of its 3 Gaussians has a colour"},
      {[](File& f) {
         f.nodes = {{0, -1, 0, 0, 5, 0, 0}};
         f.stated_nodes = 1;
       },
       "its tree has no leaves"},
  };
  for (const bool halves : {false, true}) {
    for (const auto& row : rows) {
      File file;
      file.halves = halves;
      row.change(file);
      if (halves && file.stated_count == kLeast) continue;
      expect_within_limits([&] {
        const std::string message = error_of([&] { read(bytes_of(file)); }, ErrorKind::input);
        EXPECT_THAT(message, StartsWith("test.hier: "));
        EXPECT_THAT(message, HasSubstr(row.sentence));
        return std::size_t{0};
      });
    }
  }
}

TEST(Hier, cut_and_changed_files_are_survived) {
  for (const bool halves : {false, true}) {
    File file;
    file.halves = halves;
    const std::string bytes = bytes_of(file);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_FALSE(recognises_hier(to_bytes(bytes.substr(0, size)), "a")) << size;
      EXPECT_THAT(error_of([&] { read(bytes.substr(0, size)); }, ErrorKind::input),
                  HasSubstr("test.hier: cut off"))
          << size;
    }
    for (std::size_t at = 0; at < bytes.size(); ++at) {
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ 0xff);
      error_of([&] { read(damaged); }, ErrorKind::input);
    }
  }
}

}  // namespace
}  // namespace qs::test
