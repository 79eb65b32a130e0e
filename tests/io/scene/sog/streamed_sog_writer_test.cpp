// SPDX-License-Identifier: MIT
//
// Written streamed SOGs, read back: all levels in all leaves, files and leaves of limited size.
#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/bytes/json_text.h"
#include "io/scene/reader.h"
#include "io/scene/sog/sog.h"
#include "raster/scene/cloud_order.h"
#include "support/corpus.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using nlohmann::json;

GaussianCloud spread(std::size_t count, float width, unsigned seed, int degree = 0) {
  GaussianCloud cloud = random_cloud(count, degree, seed);
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = static_cast<float>(i);
    cloud.positions[i] = {width * at / static_cast<float>(count), std::sin(at), std::cos(at)};
    cloud.log_scales[i] = glm::vec3(-3);
  }
  return cloud;
}

// Appends the leaves of a subtree.
void visit(const json& node, std::size_t levels, std::vector<json>& leaves) {
  if (node.contains("children")) {
    EXPECT_FALSE(node.contains("lods"));
    for (const json& child : node["children"]) visit(child, levels, leaves);
    return;
  }
  EXPECT_EQ(node["lods"].size(), levels);
  leaves.push_back(node);
}

void write(const std::vector<GaussianCloud>& clouds, const std::filesystem::path& folder) {
  std::vector<SogLevel> levels;
  for (const GaussianCloud& cloud : clouds) {
    SogLevel& level = levels.emplace_back();
    level.centers.assign(cloud.positions.begin(), cloud.positions.end());
    for (const glm::vec3& s : cloud.log_scales)
      level.sigmas.push_back(std::exp(std::max({s.x, s.y, s.z})));
    level.gaussians = [&cloud](std::span<const std::uint32_t> numbers) {
      return select(cloud, numbers);
    };
  }
  write_streamed_sog(levels, folder, pool(), {});
}

TEST(StreamedSogWriter, every_leaf_has_every_level_and_its_gaussians_are_within_its_bound) {
  struct Row {
    std::size_t finest, coarse;
    float width;
    std::size_t leaves;
  };
  for (const Row& row : std::vector<Row>{{1, 1, 1, 1},
                                         {9000, 1, 5, 1},
                                         {8192, 10, 100, 1},
                                         {8193, 10, 100, 2},
                                         {40000, 1, 1000, 8},
                                         {40000, 40000, 1000, 8}}) {
    const TemporaryFolder folder;
    const std::vector<GaussianCloud> levels = {spread(row.finest, row.width, 1),
                                               spread(row.coarse, row.width, 2)};
    write(levels, folder / "out");
    const json meta = json::parse(read_text_file(folder / "out/lod-meta.json", 1 << 20));
    EXPECT_EQ(meta["counts"], (json{row.finest, row.coarse}));
    EXPECT_EQ(meta["count"], row.finest + row.coarse);
    EXPECT_EQ(meta["lodLevels"], 2);
    std::vector<json> leaves;
    visit(meta["tree"], 2, leaves);
    EXPECT_EQ(leaves.size(), row.leaves);
    for (std::size_t k = 0; k < 2; ++k) {
      std::size_t all = 0;
      for (const json& leaf : leaves) {
        const json& part = leaf["lods"][std::to_string(k)];
        const std::string name = meta["filenames"][part["file"].get<std::size_t>()];
        const GaussianCloud file = read_scene(folder / "out" / name, pool()).cloud;
        const auto offset = part["offset"].get<std::size_t>(),
                   count = part["count"].get<std::size_t>();
        ASSERT_LE(offset + count, file.size());
        all += count;
        for (std::size_t i = offset; i < offset + count; ++i)
          for (int axis = 0; axis < 3; ++axis) {
            const float at = file.positions[i][axis];
            EXPECT_GE(at, leaf["bound"]["min"][axis].get<float>());
            EXPECT_LE(at, leaf["bound"]["max"][axis].get<float>());
          }
      }
      EXPECT_EQ(all, levels[k].size());
    }
    const Scene scene = read_scene(folder / "out/lod-meta.json", pool());
    EXPECT_EQ(scene.cloud.size(), row.finest);
    EXPECT_EQ(scene.levels->levels, 2u);
  }
}

TEST(StreamedSogWriter, files_have_at_most_524288_gaussians) {
  // Two leaves of 300,000 each do not fit into one file; the small level does.
  const TemporaryFolder folder;
  GaussianCloud finest = spread(600'000, 10, 3);
  const std::vector<GaussianCloud> levels = {std::move(finest), spread(100, 10, 4)};
  write(levels, folder / "out");
  const json meta = json::parse(read_text_file(folder / "out/lod-meta.json", 1 << 20));
  EXPECT_EQ(meta["filenames"], (json{"0_0/meta.json", "1_0/meta.json", "0_1/meta.json"}));
  EXPECT_EQ(read_scene(folder / "out/0_1/meta.json", pool()).cloud.size(), 300'000u);
  EXPECT_EQ(read_scene(folder / "out/lod-meta.json", pool()).cloud.size(), 600'000u);
}

TEST(StreamedSogWriter, keeps_sh_and_antialiasing) {
  const TemporaryFolder folder;
  std::vector<GaussianCloud> levels = {spread(200, 1, 5, 2), spread(50, 1, 6, 2)};
  for (GaussianCloud& level : levels) level.antialiased = true;
  write(levels, folder / "out");
  const Scene scene = read_scene(folder / "out/lod-meta.json", pool());
  EXPECT_EQ(scene.cloud.sh_degree, 2);
  EXPECT_TRUE(scene.cloud.antialiased);
  EXPECT_EQ(json::parse(read_text_file(folder / "out/lod-meta.json", 1 << 20))["model"],
            "antialiased");
}

TEST(StreamedSogWriter, gaussians_at_one_place_make_leaves_too) {
  const TemporaryFolder folder;
  std::vector<GaussianCloud> levels = {spread(20000, 1, 7), spread(9, 1, 8)};
  for (GaussianCloud& level : levels)
    for (std::size_t i = 0; i < level.size(); ++i) {
      level.positions[i] = {1, 2, 3};
      level.log_scales[i] = glm::vec3(4);  // wider than 16 units
    }
  write(levels, folder / "out");
  EXPECT_EQ(read_scene(folder / "out/lod-meta.json", pool()).cloud.size(), 20000u);
}

}  // namespace
}  // namespace qs::test
