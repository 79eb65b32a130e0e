// SPDX-License-Identifier: MIT
//
// Cases that are not in the corpus: .spz version 1, SH degree 4, every coordinate system.
#include "io/scene/spz/spz.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <glm/gtc/packing.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "io/bytes/byte_cursor.h"
#include "support/corpus.h"
#include "support/gzip.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// The header of a file with one Gaussian.
std::string header(char version, char sh_degree, char fractional_bits, char flags = 0) {
  std::string text("NGSP\0\0\0\0\1\0\0\0", 12);
  text[4] = version;
  return text + sh_degree + fractional_bits + flags + '\0';
}

Scene read(const std::vector<std::byte>& bytes) {
  Scene scene;
  scene.path = "test.spz";
  ThreadPool pool(2);
  read_spz(bytes, scene.path, pool, {}, scene);
  return scene;
}

std::string error_of(const std::vector<std::byte>& bytes) {
  try {
    read(bytes);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

const std::string kAlphaColorScale("\x80\x80\x80\x80\xa0\xa0\xa0", 7);

TEST(Spz, version_1_has_half_float_positions) {
  // 1.5, -2, 2^-24 (the smallest half) in x right, y up, z back.
  const std::string text = header(1, 0, 0) + std::string("\x00\x3e\x00\xc0\x01\x00", 6) +
                           kAlphaColorScale + "\x80\x80\x80";
  const Scene scene = read(to_bytes(gzip(text, 9)));
  EXPECT_EQ(scene.cloud.positions[0], glm::vec3(1.5f, 2, -5.9604645e-8f));
  EXPECT_EQ(scene.cloud.log_scales[0], glm::vec3(0));
  EXPECT_EQ(scene.format, "spz, version 1");
}

TEST(Spz, infinite_half_floats_are_dropped) {
  const std::string text = header(1, 0, 0) + std::string("\x00\x7c\x00\xc0\x01\x00", 6) +
                           kAlphaColorScale + "\x80\x80\x80";
  EXPECT_THAT(error_of(to_bytes(gzip(text, 9))), HasSubstr("position"));
}

TEST(Spz, positions_are_signed_24_bit_fixed_point) {
  const std::string position("\x00\x10\x00\xff\xff\xff\x00\x00\x80", 9);
  const std::string text =
      header(3, 0, 12) + position + kAlphaColorScale + std::string("\0\0\0\xc0", 4);
  const Scene scene = read(to_bytes(gzip(text, 9)));
  EXPECT_EQ(scene.cloud.positions[0], glm::vec3(1, 1 / 4096.f, 2048));
  EXPECT_EQ(scene.cloud.rotations[0], glm::quat(1, 0, 0, 0));
}

TEST(Spz, degree_4_is_cut_to_degree_3) {
  std::string sh(72, '\x80');
  sh[0] = '\xc0';       // Y_1^-1, red: 0.5, odd in y
  sh[3 * 14] = '\xc0';  // Y_3^3, red
  sh[3 * 15] = '\xff';  // degree 4
  const std::string text = header(3, 4, 12) + std::string(9, '\0') + kAlphaColorScale +
                           std::string("\0\0\0\xc0", 4) + sh;
  const Scene scene = read(to_bytes(gzip(text, 9)));
  EXPECT_EQ(scene.cloud.sh_degree, 3);
  EXPECT_EQ(scene.cloud.sh.size(), 16u);
  EXPECT_EQ(scene.cloud.sh[1], glm::vec3(-0.5f, 0, 0));
  EXPECT_EQ(scene.cloud.sh[15], glm::vec3(0.5f, 0, 0));
  EXPECT_THAT(scene.warnings, SizeIs(1));
}

TEST(Spz, antialiased_flag_is_kept) {
  for (const char flag : {'\0', '\1'}) {
    const std::string text = header(3, 0, 12, flag) + std::string(9, '\0') + kAlphaColorScale +
                             std::string("\0\0\0\xc0", 4);
    EXPECT_EQ(read(to_bytes(gzip(text, 9))).cloud.antialiased, flag == '\1');
  }
}

// ---- trees of levels of detail
// --------------------------------------------------------------------

struct TreeFile {
  int version = 2, flags = 0x80;
  std::vector<int> counts = {2, 0, 2, 0, 0};
  std::vector<std::uint32_t> starts = {1, 0, 3, 0, 0};
  std::string alphas = std::string("\xff\x40\xff\x80\x7f");
};

// Gaussian i is at x = i.
std::string text_of(const TreeFile& file) {
  const std::size_t count = file.counts.size();
  std::string text = header(static_cast<char>(file.version), 1, 0, static_cast<char>(file.flags));
  text[8] = static_cast<char>(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (file.version == 1)
      put_values(text, glm::packHalf1x16(static_cast<float>(i)), std::uint32_t{0});
    else
      text += static_cast<char>(i) + std::string(8, '\0');
  }
  text += file.alphas + std::string(3 * count, '\x80') + std::string(3 * count, '\xa0');
  text += std::string((file.version < 3 ? 3 : 4) * count, '\x80');
  for (std::size_t i = 0; i < count; ++i) text += std::string(9, static_cast<char>(0x80 + i));
  for (const int each : file.counts) put_values(text, static_cast<std::uint16_t>(each));
  for (const std::uint32_t start : file.starts) put_values(text, start);
  return text;
}

std::string error_of(const TreeFile& file) { return error_of(to_bytes(gzip(text_of(file), 9))); }

TEST(Spz, leaves_of_a_tree_are_read) {
  for (const int version : {1, 2, 3}) {
    TreeFile file;
    file.version = version;
    const Scene scene = read(to_bytes(gzip(text_of(file), 9)));
    const GaussianCloud& cloud = scene.cloud;
    ASSERT_EQ(cloud.size(), 3u);
    for (const auto& [i, row] : {std::pair(0u, 1), std::pair(1u, 3), std::pair(2u, 4)}) {
      EXPECT_EQ(cloud.positions[i].x, static_cast<float>(row));
      EXPECT_EQ(std::abs(cloud.sh[4 * i + 1].x), static_cast<float>(row) / 128);
    }
    // Opacities are doubled; 1 is stored as 128.
    EXPECT_FLOAT_EQ(cloud.opacity_logits[0], std::log(128 / 127.f));
    EXPECT_EQ(cloud.opacity_logits[1], INFINITY);
    EXPECT_FLOAT_EQ(cloud.opacity_logits[2], std::log(254 / 1.f));
    EXPECT_EQ(scene.levels, (LevelsOfDetail{.levels = 3, .nodes = 5, .leaves = 3, .merged = 2}));
    EXPECT_THAT(scene.warnings, IsEmpty());
  }
}

TEST(Spz, extensions_follow_a_tree) {
  TreeFile file;
  file.flags = 0x82;
  std::string text = text_of(file);
  put_values(text, 0xADBE0003u, 4u, 6u);  // RDF
  EXPECT_EQ(read(to_bytes(gzip(text, 9))).axes, "RDF");
}

TEST(Spz, leaves_of_a_tree_above_opacity_1_are_named) {
  TreeFile file;
  file.alphas = std::string("\xff\x81\xff\xff\x7f");
  EXPECT_THAT(read(to_bytes(gzip(text_of(file), 9))).warnings,
              ElementsAre("2 leaves have an opacity above 1, which was clamped."));
}

TEST(Spz, damaged_trees_have_a_sentence) {
  using Counts = std::vector<int>;
  using Starts = std::vector<std::uint32_t>;
  const struct {
    Counts counts;
    Starts starts;
    std::string sentence;
  } rows[] = {
      {{2, 0, 2, 0, 0}, {0, 0, 3, 0, 0}, "the children of node 0 begin with node 0"},
      {{2, 0, 2, 0, 0}, {1, 0, 1, 0, 0}, "the children of node 2 begin with node 1"},
      {{2, 0, 2, 0, 0}, {1, 0, 2, 0, 0}, "the children of node 2 begin with node 2"},
      {{3, 0, 2, 0, 0}, {1, 0, 3, 0, 0}, "node 3 is the child of two nodes"},
      {{2, 0, 1, 0, 0}, {1, 0, 3, 0, 0}, "node 4 of its tree is the child of no node"},
      {{2, 0, 3, 0, 0}, {1, 0, 3, 0, 0}, "node 2 has 3 children from node 3 on"},
      {{2, 0, 65535, 0, 0}, {1, 0, 4294967295, 0, 0}, "node 2 has 65535 children from node 4294"},
      {{0, 0, 0, 0, 0}, {0, 0, 0, 0, 0}, "node 1 of its tree is the child of no node"},
  };
  for (const auto& row : rows) {
    TreeFile file;
    file.counts = row.counts;
    file.starts = row.starts;
    EXPECT_THAT(error_of(file), HasSubstr("test.spz: " + row.sentence));
  }
}

TEST(Spz, cut_trees_have_a_sentence) {
  const std::string text = text_of(TreeFile{});
  for (std::size_t size = 16; size < text.size(); ++size)
    EXPECT_THAT(error_of(to_bytes(gzip(text.substr(0, size), 1))), HasSubstr("test.spz: cut off"))
        << size;
  EXPECT_THAT(error_of(to_bytes(gzip(text + "x", 1))), HasSubstr("more data"));
}

TEST(Spz, version_4_has_no_trees) {
  auto bytes = file_bytes(committed_corpus() / "valid/spz_v4_sh3.spz");
  bytes[14] |= std::byte{0x80};
  EXPECT_THAT(error_of(bytes), HasSubstr("a tree of levels of detail in version 4"));
}

TEST(Spz, every_frame_with_parallel_axes_is_turned_to_right_down_forward) {
  auto bytes = file_bytes(committed_corpus() / "valid/spz_v4_ext_coordsys_rdf.spz");
  constexpr std::size_t kNumber = 32 + 8;  // after the header and the record's own
  ASSERT_EQ(bytes[kNumber], std::byte{6});
  const GaussianCloud rdf = read(bytes).cloud;
  const std::array<std::string, 8> frames = {"LDB", "RDB", "LUB", "RUB",
                                             "LDF", "RDF", "LUF", "RUF"};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    SCOPED_TRACE(frames[i]);
    bytes[kNumber] = static_cast<std::byte>(i + 1);
    const Scene scene = read(bytes);
    EXPECT_THAT(scene.warnings, IsEmpty());
    const glm::vec3 signs(frames[i][0] == 'R' ? 1 : -1, frames[i][1] == 'D' ? 1 : -1,
                          frames[i][2] == 'F' ? 1 : -1);
    EXPECT_EQ(scene.cloud.positions[77], rdf.positions[77] * signs);
  }
  bytes[kNumber] = std::byte{9};
  EXPECT_THAT(read(bytes).warnings, SizeIs(1));
}

TEST(Spz, one_byte_too_much_or_too_little_is_an_error) {
  const std::string text =
      header(3, 0, 12) + std::string(9, '\0') + kAlphaColorScale + std::string("\0\0\0\xc0", 4);
  EXPECT_EQ(error_of(to_bytes(gzip(text, 9))), "no error");
  EXPECT_THAT(error_of(to_bytes(gzip(text + "x", 9))), HasSubstr("more data"));
  EXPECT_THAT(error_of(to_bytes(gzip(text.substr(0, text.size() - 1), 9))), HasSubstr("cut off"));
}

}  // namespace
}  // namespace qs::test
