// SPDX-License-Identifier: MIT
//
// Parts of binary .ply files, and files that have no parts.
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/scene/ply/ply.h"
#include "io/scene/writer.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::HasSubstr;

std::string with_text(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return text.replace(at, from.size(), to);
}

// 40 Gaussians of degree 1 as a file.
std::string forty_gaussians() {
  const TemporaryFolder folder;
  write_scene(random_cloud(40, 1, 3), folder / "a.ply", pool());
  std::ifstream file(folder / "a.ply", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

ByteSpan bytes_in(const std::string& text) { return std::as_bytes(std::span(text)); }

GaussianCloud cloud_in(const std::string& text) {
  Scene scene;
  read_ply(bytes_in(text), "a.ply", pool(), {}, scene);
  EXPECT_THAT(scene.warnings, testing::Each(testing::Not(HasSubstr("bytes"))));
  return std::move(scene.cloud);
}

TEST(PlyPart, parts_are_the_rows_of_the_file) {
  const std::string plain = forty_gaussians(), header_end = "end_header\n";
  const std::size_t body = plain.find(header_end) + header_end.size();
  std::string header = plain.substr(0, body);
  for (std::size_t at = 0; (at = header.find('\n', at)) != header.npos; at += 2)
    header.replace(at, 1, "\r\n");
  const std::vector<std::string> files = {
      plain, header + plain.substr(body),
      with_text(plain, header_end, "comment element vertex 3\n" + header_end),
      with_text(plain, header_end, "comment element\n" + header_end)};
  for (const std::string& text : files) {
    ASSERT_EQ(divisible_rows(bytes_in(text), "a.ply"), 40u);
    const GaussianCloud whole = cloud_in(text);
    std::size_t next = 0;
    for (const std::size_t end : {1, 17, 39, 40}) {
      const GaussianCloud part = cloud_in(ply_part(bytes_in(text), "a.ply", next, end));
      ASSERT_EQ(part.size(), end - next);
      for (std::size_t i = 0; i < part.size(); ++i, ++next) {
        EXPECT_EQ(part.positions[i], whole.positions[next]);
        EXPECT_EQ(part.sh[4 * i + 3], whole.sh[4 * next + 3]);
      }
    }
  }
}

TEST(PlyPart, elements_behind_the_vertices_are_left_out) {
  const std::string text = with_text(forty_gaussians(), "end_header\n",
                                     "element camera 2\nproperty float fx\nend_header\n") +
                           "12345678";
  ASSERT_EQ(divisible_rows(bytes_in(text), "a.ply"), 40u);
  Scene scene;
  read_ply(bytes_in(ply_part(bytes_in(text), "a.ply", 10, 30)), "a.ply", pool(), {}, scene);
  EXPECT_EQ(scene.cloud.size(), 20u);
}

TEST(PlyPart, other_files_have_no_parts) {
  const std::string text = forty_gaussians();
  for (const std::string& other :
       {std::string(), std::string("no ply"), with_text(text, "binary_little_endian", "ascii"),
        with_text(text, "end_header\n", "property list uchar int more\nend_header\n"),
        with_text(text, "element vertex", "element camera 1\nproperty float fx\nelement vertex")})
    EXPECT_EQ(divisible_rows(bytes_in(other), "a.ply"), 0u);
}

TEST(PlyPart, rows_beyond_the_file_are_one_sentence) {
  const std::string text = forty_gaussians();
  for (const std::string& damaged :
       {text.substr(0, text.size() - 1), with_text(text, "vertex 40", "vertex 41"),
        with_text(text, "vertex 40", "vertex 18446744073709551615")})
    EXPECT_THAT(error_of([&] { divisible_rows(bytes_in(damaged), "a.ply"); }),
                HasSubstr("a.ply: "));
}

}  // namespace
}  // namespace qs::test
