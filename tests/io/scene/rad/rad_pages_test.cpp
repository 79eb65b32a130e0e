// SPDX-License-Identifier: MIT
//
// Trees of .rad files that are read page by page: the pages hold what the whole file holds, and
// damaged, cut and replaced files have their sentence.
#include "io/scene/rad/rad_pages.h"

#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/cloud/cloud_memory.h"
#include "io/scene/rad/rad_writer.h"
#include "io/scene/reader.h"
#include "raster/pages/page_stream.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A tree of two pages in order of breadth, each inner node with three children.
std::string page_file(std::uint32_t nodes, bool own = true, glm::vec3 shift = glm::vec3(0)) {
  std::vector<RadNodes> chunks;
  for (std::uint32_t i = 0; i < nodes; ++i) {
    if (i % RadWriter::kChunk == 0) chunks.emplace_back();
    LodNode node;
    const auto f = static_cast<float>(i);
    node.center = shift + glm::vec3(f / 100, std::sin(f), 2);
    node.scales = {0.01f, 0.02f, 0.03f};
    node.alpha = 0.5f;
    const std::uint32_t first = 3 * i + 1;
    node.parent = i == 0 ? 0 : (i - 1) / 3;
    if (first < nodes) {
      node.first_child = first;
      node.child_count = static_cast<std::uint16_t>(std::min(nodes - first, 3u));
      node.gains.fill(static_cast<std::uint8_t>(200 - std::min(i / 1000, 150u)));
      node.layers = 0.5f;
      node.opacities = 1;
      node.radius = 1;
    }
    chunks.back().nodes.push_back(node);
    for (int k = 0; k < 3; ++k) chunks.back().sh.push_back(0x3800);  // 0.5
  }
  std::ostringstream stream;
  RadWriter writer(stream, {nodes, 0, 0.5f, false}, pool());
  writer.write(chunks);
  writer.finish();
  std::string text = stream.str();
  if (!own) {  // as another program writes it
    const std::size_t at = text.find("\"quadsplat\"");
    text.replace(at, 11, "\"quadsplit\"");
  }
  return text;
}

class RadPagesTest : public testing::Test {
 protected:
  void write(const std::string& text) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << text;
  }
  Scene streamed(const std::string& axes = "") {
    ReadOptions options;
    options.streams = StreamedTrees::all;
    options.axes = axes;
    return read_scene(path_, pool(), options);
  }
  static LodGain gain(const Scene& scene) {
    return [smallest = scene.stream->footprint()](const LodPage& page, std::size_t row) {
      return smallest > 0 ? lod_gain(page.nodes[row], smallest, 1) : page.nodes[row].radius;
    };
  }
  // The Gaussians of all leaves, read page by page.
  static GaussianCloud leaves(const Scene& scene) {
    const StreamedCut all = scene.stream->await_cut(gain(scene), {}, pool());
    GaussianCloud cloud;
    cloud.resize(all.cut.count, 0);
    std::size_t k = 0;
    for (const LodPart& part : all.cut.parts)
      part.for_each([&](std::size_t row) {
        const GaussianCloud& page = all.tree.pages[part.page]->cloud;
        cloud.positions[k] = page.positions[row];
        cloud.log_scales[k] = page.log_scales[row];
        cloud.rotations[k] = page.rotations[row];
        cloud.opacity_logits[k] = page.opacity_logits[row];
        cloud.sh[k++] = page.sh[row];
      });
    return cloud;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "tree.rad";
};

void expect_same_bytes(const GaussianCloud& a, const GaussianCloud& b) {
  ASSERT_EQ(a.size(), b.size());
  const auto same = [&](const auto& x, const auto& y) {
    return std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0;
  };
  EXPECT_TRUE(same(a.positions, b.positions));
  EXPECT_TRUE(same(a.log_scales, b.log_scales));
  EXPECT_TRUE(same(a.rotations, b.rotations));
  EXPECT_TRUE(same(a.opacity_logits, b.opacity_logits));
  EXPECT_TRUE(same(a.sh, b.sh));
}

TEST_F(RadPagesTest, all_leaves_have_the_bits_of_the_whole_file) {
  for (const std::uint32_t nodes : {1u, 4u, 65536u, 65537u, 140000u}) {
    for (const bool own : {true, false}) {
      write(page_file(nodes, own));
      for (const char* axes : {"", "RUB", "FLU"}) {
        ReadOptions options;
        options.axes = axes;
        const Scene whole = read_scene(path_, pool(), options);
        const Scene scene = streamed(axes);
        ASSERT_TRUE(scene.stream);
        EXPECT_EQ(scene.axes, whole.axes);
        EXPECT_EQ(scene.file_bytes, whole.file_bytes);
        EXPECT_EQ(scene.levels->nodes, nodes);
        EXPECT_EQ(scene.levels->has_errors, own);
        EXPECT_GT(scene.cloud.size(), 0u);
        expect_same_bytes(leaves(scene), whole.cloud);
        EXPECT_THAT(scene.stream->take_sentences(), IsEmpty());
      }
    }
  }
}

TEST_F(RadPagesTest, large_coordinates_of_other_programs_count_from_one_origin_on_all_pages) {
  write(page_file(70'000, false, {500'000, 4'650'000, 200}));
  const GaussianCloud whole = read_scene(path_, pool()).cloud;
  const Scene scene = streamed();
  EXPECT_NE(scene.cloud.origin, glm::dvec3(0));
  const GaussianCloud paged = leaves(scene);
  for (std::size_t i = 0; i < whole.size(); ++i)
    ASSERT_EQ(whole.origin + glm::dvec3(whole.positions[i]),
              scene.cloud.origin + glm::dvec3(paged.positions[i]));
}

TEST_F(RadPagesTest, pages_have_the_given_memory_or_half_of_what_is_available) {
  write(page_file(10));
  ReadOptions options;
  options.streams = StreamedTrees::all;
  options.page_memory = 12'345'678;
  EXPECT_EQ(read_scene(path_, pool(), options).stream->facts().most_bytes, 12'345'678u);
  for (const std::uint64_t memory : {std::uint64_t{0}, ~std::uint64_t{0}}) {
    options.page_memory = memory;
    const std::uint64_t most = read_scene(path_, pool(), options).stream->facts().most_bytes;
    EXPECT_GT(most, available_memory() / 4);
    EXPECT_LT(most, available_memory());
  }
}

TEST_F(RadPagesTest, other_files_are_read_whole) {
  write(page_file(10));
  EXPECT_FALSE(read_scene(path_, pool()).stream);
  ReadOptions options;
  options.streams = StreamedTrees::large;  // it fits into memory
  EXPECT_FALSE(read_scene(path_, pool(), options).stream);
  std::string flat = page_file(1);
  flat.replace(flat.find("\"lodTree\":true"), 14, "\"lodTree\":null");
  write(flat);
  const Scene scene = streamed();
  EXPECT_FALSE(scene.stream);
  EXPECT_THAT(scene.warnings,
              ElementsAre("It has no tree of levels of detail, so it is drawn whole."));
}

TEST_F(RadPagesTest, a_damaged_page_is_named_and_its_parents_stay) {
  const std::string sound = page_file(140000);
  const std::size_t second = sound.find("RADC", sound.find("RADC") + 1);
  const std::size_t third = sound.find("RADC", second + 1);
  struct {
    std::size_t at;
    const char* sentence;
  } const rows[] = {{second, "chunk 1: does not begin with 'RADC'"},
                    {second + 6, "chunk 1: cut off: the description needs"},
                    {second + 300, "chunk 1"},
                    {third - 60, "chunk 1: quadsplat: damaged: its checksum is wrong"}};
  for (const auto& row : rows) {
    std::string damaged = sound;
    for (std::size_t i = 0; i < 24; ++i)
      damaged[row.at + i] = static_cast<char>(damaged[row.at + i] ^ 0x55);
    write(damaged);
    const Scene scene = streamed();
    const std::size_t count = leaves(scene).size();
    EXPECT_GT(count, 1000u);
    const auto sentences = scene.stream->take_sentences();
    ASSERT_EQ(sentences.size(), 1u) << row.at;
    EXPECT_THAT(sentences[0], HasSubstr(row.sentence));
    EXPECT_THAT(sentences[0], HasSubstr("; coarser nodes are drawn in its place"));
  }
}

TEST_F(RadPagesTest, children_outside_of_the_tree_are_damage) {
  for (const bool before : {true, false}) {
    RadNodes nodes;
    nodes.nodes.resize(3);
    nodes.sh.assign(9, 0);
    for (LodNode& node : nodes.nodes) node.scales = {1, 1, 1};
    nodes.nodes[1].child_count = 2;
    nodes.nodes[1].first_child = before ? 1 : 2;
    std::ostringstream stream;
    RadWriter writer(stream, {3, 0, 1, false}, pool());
    writer.write({&nodes, 1});
    writer.finish();
    write(stream.str());
    EXPECT_THAT(error_of([&] { streamed(); }, ErrorKind::input),
                HasSubstr("chunk 0: node 1 has 2 children from node"));
  }
}

TEST_F(RadPagesTest, cut_files_have_a_sentence) {
  const std::string sound = page_file(70000);
  for (const std::size_t bytes : {0, 3, 7, 8, 100, 300, 1000}) {
    write(sound.substr(0, bytes));
    EXPECT_THAT(error_of([&] { streamed(); }), HasSubstr("tree.rad")) << bytes;
  }
  write(sound.substr(0, sound.size() - 10));  // opens: only the last page is cut
  const Scene scene = streamed();
  leaves(scene);
  EXPECT_THAT(scene.stream->take_sentences(), ElementsAre(HasSubstr("chunk 1: cut off")));
}

TEST_F(RadPagesTest, a_replaced_or_truncated_file_is_not_read_any_more) {
  const std::string sound = page_file(140000);
  for (const bool replaces : {true, false}) {
    write(sound);
    const Scene scene = streamed();
    if (replaces) {
      std::ofstream(folder_ / "new.rad", std::ios::binary) << sound;
      std::filesystem::rename(folder_ / "new.rad", path_);
    } else {
      std::filesystem::resize_file(path_, sound.size() / 3);
    }
    EXPECT_GT(leaves(scene).size(), 1000u);
    EXPECT_EQ(scene.stream->facts().resident, 1u);
    EXPECT_THAT(scene.stream->take_sentences(), ElementsAre(HasSubstr("another program changed")));
  }
}

}  // namespace
}  // namespace qs::test
