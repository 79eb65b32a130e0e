// SPDX-License-Identifier: MIT
//
// Cases that are not in the corpus: .spz version 1, SH degree 4, every coordinate system.
#include "io/scene/spz/spz.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "support/corpus.h"
#include "support/gzip.h"

namespace qs::test {
namespace {

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

TEST(Spz, tree_of_levels_is_refused) {
  const std::string text = header(3, 0, 12, '\x80') + std::string(9, '\0') + kAlphaColorScale +
                           std::string("\0\0\0\xc0", 4);
  EXPECT_THAT(error_of(to_bytes(gzip(text, 9))), HasSubstr("level-of-detail"));
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
