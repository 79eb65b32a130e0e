// SPDX-License-Identifier: MIT
//
// Instances of a tree are one tree: its leaves are the leaves of all instances, and a copy of
// another size is cut as the tree itself from a distance of that size.
#include "learn/lod/instance_tree.h"

#include <algorithm>
#include <fstream>
#include <limits>

#include <glm/gtc/matrix_transform.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/scene/instances.h"
#include "io/scene/writer.h"
#include "learn/lod/build.h"
#include "learn/lod/cut.h"
#include "raster/pages/page_stream.h"
#include "support/error_of.h"
#include "support/instances_text.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::HasSubstr;

class InstanceTrees : public testing::Test {
 protected:
  // A tree of several buckets, and instances of it.
  std::filesystem::path write(const std::vector<Instance>& instances, std::size_t count = 5000,
                              const glm::dvec3& origin = glm::dvec3(0)) {
    GaussianCloud one = random_cloud(count, 3, 7);
    one.origin = origin;
    write_scene(one, folder_ / "one.ply", pool());
    LodBuild build;
    build.inputs = {folder_ / "one.ply"};
    build.output = folder_ / "one.rad";
    build.memory = 64'000'000;
    build.warn = [](const std::string&) {};
    build_lod(build, pool());
    std::ofstream(folder_ / "all.json") << format_instances("one.rad", instances);
    return folder_ / "all.json";
  }

  static Scene open(const std::filesystem::path& path) {
    ReadOptions options;
    options.streams = StreamedTrees::all;
    Scene scene;
    scene.path = path;
    EXPECT_TRUE(stream_instances(options, pool(), scene));
    return scene;
  }

  TemporaryFolder folder_;
};

const std::vector<Instance> kInstances{
    {},
    {{12, 1, -3}, glm::angleAxis(0.7, glm::dvec3(0, 1, 0)), 2.5, {1, 0.5f, 0.25f}},
    {{-9, 0, 4}, glm::angleAxis(-2.0, glm::normalize(glm::dvec3(1, 1, 0))), 0.3, {1, 1, 2}}};

TEST_F(InstanceTrees, all_leaves_are_those_of_the_instances_read_whole) {
  const auto path = write(kInstances);
  const GaussianCloud whole = read_scene(path, pool()).cloud;
  const Scene scene = open(path);
  ASSERT_TRUE(scene.stream);
  EXPECT_EQ(scene.format, "instances of rad");
  Camera camera;
  camera.width = camera.height = 64;
  camera.focal_px = {64, 64};
  const LodView view(camera, 1);
  const StreamedCut made =
      scene.stream->await_cut(gain_in(view, scene.stream->footprint()), {}, pool());
  EXPECT_TRUE(made.cut.missing.empty());
  const GaussianCloud cut = cut_cloud(made.tree, made.cut, view, 0.3, pool());
  ASSERT_EQ(cut.size(), whole.size());
  EXPECT_EQ(cut.origin, whole.origin);
  EXPECT_EQ(cut.positions, whole.positions);
  EXPECT_EQ(cut.log_scales, whole.log_scales);
  EXPECT_EQ(cut.rotations, whole.rotations);
  EXPECT_EQ(cut.opacity_logits, whole.opacity_logits);
  EXPECT_EQ(cut.sh, whole.sh);
}

TEST_F(InstanceTrees, a_tree_far_away_has_instances_there) {
  const auto path = write({{}, {{12, 1, -3}}}, 500, {500'000, 4'650'000, 200});
  const GaussianCloud whole = read_scene(path, pool()).cloud;
  EXPECT_NE(whole.origin, glm::dvec3(0));
  const LodPages tree = open(path).stream->whole_tree(pool());
  const GaussianCloud& top = tree.pages[0]->cloud;
  ASSERT_EQ(tree.placement(1), &tree.instances->placements[0]);
  const GaussianCloud& page = tree.pages[1]->cloud;
  for (std::size_t row = 0; row < page.size(); ++row)
    if (tree.pages[1]->nodes[row].child_count == 0) {
      const glm::dvec3 at = top.origin + glm::dvec3(tree.placement(1)->at(page.positions[row]));
      const auto same = [&](const glm::vec3& position) {
        return glm::distance(whole.origin + glm::dvec3(position), at) < 1e-3;
      };
      ASSERT_TRUE(std::ranges::any_of(whole.positions, same)) << row;
    }
}

TEST_F(InstanceTrees, a_larger_copy_is_cut_as_from_nearby) {
  const Scene scene = open(write({{}, {{1000, 0, 0}, {1, 0, 0, 0}, 16, glm::vec3(1)}}));
  ASSERT_TRUE(scene.stream);
  // Nodes of one copy, from `distance` in units of the copy.
  const auto nodes_of = [&](bool is_large, double distance) {
    Camera camera;
    camera.width = camera.height = 64;
    camera.focal_px = {64, 64};
    camera.near_depth *= is_large ? 16 : 1;
    const glm::dvec3 eye =
        is_large ? glm::dvec3(1000, 0, -16 * distance) : glm::dvec3(0, 0, -distance);
    camera.view_from_world = glm::translate(glm::dmat4(1), -eye);
    const LodView view(camera, 1);
    const StreamedCut made =
        scene.stream->await_cut(gain_in(view, scene.stream->footprint()),
                                {std::numeric_limits<std::size_t>::max(), 1e-3f}, pool());
    std::size_t count = 0;
    for (const LodPart& part : made.cut.parts)
      part.for_each([&](std::size_t row) {
        const auto [center, radius] =
            lod_ball(*made.tree.pages[part.page], row, made.tree.placement(part.page));
        count += (center.x > 500) == is_large ? 1 : 0;
      });
    return count;
  };
  for (const double distance : {10.0, 100.0, 1000.0}) {
    const std::size_t small = nodes_of(false, distance), large = nodes_of(true, distance);
    EXPECT_GT(small, 10u);
    EXPECT_LT(small, 5000u);
    EXPECT_NEAR(static_cast<double>(small), static_cast<double>(large), 2) << distance;
  }
}

// The page of such a tree has one node, so the tree over the instances has a page for each node.
TEST_F(InstanceTrees, a_single_gaussian_has_instances) {
  const Scene scene = open(write(kInstances, 1));
  const StreamedCut made = scene.stream->await_cut(
      LodGain([](const LodPage&, std::size_t) { return 1.0f; }), {}, pool());
  EXPECT_EQ(made.cut.count, 3u);
  const StreamFacts facts = scene.stream->facts();
  EXPECT_EQ(facts.nodes, facts.resident);
  EXPECT_LE(facts.nodes, 5u);
}

TEST_F(InstanceTrees, one_node_stands_for_all) {
  const Scene scene = open(write(kInstances));
  const StreamedCut made = scene.stream->await_cut(
      LodGain([](const LodPage&, std::size_t) { return 1.0f; }), {1, 0}, pool());
  ASSERT_EQ(made.cut.count, 1u);
  const GaussianCloud& top = made.tree.pages[0]->cloud;
  EXPECT_LT(glm::length(top.positions[0] - glm::vec3(12, 1, -3)), 12);  // the largest instance
  EXPECT_GT(made.tree.pages[0]->nodes[0].radius, 12);
}

TEST_F(InstanceTrees, places_that_no_picture_shows_are_refused) {
  const auto path = write({{}, {{1e30, 0, 0}, {1, 0, 0, 0}, 1, glm::vec3(1)}});
  EXPECT_THAT(error_of([&] { open(path); }), HasSubstr("instance 1 cannot be drawn"));
}

}  // namespace
}  // namespace qs::test
