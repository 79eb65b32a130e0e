// SPDX-License-Identifier: MIT
//
// Variants of .ply that are not in the corpus, written here byte by byte.
#include "io/scene/ply/ply.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/fail.h"
#include "io/scene/reader.h"
#include "support/corpus.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const char* const kBase =
    "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3";

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

// A header for one vertex whose properties have the given type.
std::string header(const std::string& format, const std::string& type, const std::string& names) {
  std::string text = "ply\nformat " + format + " 1.0\nelement vertex 1\n";
  for (const std::string& name : words_of(names))
    text += fmt::format("property {} {}\n", type, name);
  return text + "end_header\n";
}

std::string rest_names(int count) {
  std::string names;
  for (int i = 0; i < count; ++i) names += fmt::format(" f_rest_{}", i);
  return names;
}

template <class T>
void put(std::string& body, double value, bool big_endian) {
  auto typed = static_cast<T>(value);
  char bytes[sizeof(T)];
  std::memcpy(bytes, &typed, sizeof(T));
  if (big_endian) std::reverse(bytes, bytes + sizeof(T));
  body.append(bytes, sizeof(T));
}

Scene read(const std::string& text) {
  const auto bytes = to_bytes(text);
  Scene scene;
  scene.path = "test.ply";
  ThreadPool pool(2);
  read_ply(bytes, scene.path, pool, {}, scene);
  return scene;
}

std::string error_of(const std::string& text) {
  try {
    read(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

template <class T>
void expect_type_is_read(const char* name) {
  for (const bool big_endian : {false, true}) {
    SCOPED_TRACE(name);
    std::string file =
        header(big_endian ? "binary_big_endian" : "binary_little_endian", name, kBase);
    for (const double value : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 0, 1, 0, 0}) {
      put<T>(file, value, big_endian);
    }
    const Scene scene = read(file);
    EXPECT_EQ(scene.cloud.positions[0], glm::vec3(1, 2, 3));
    EXPECT_EQ(scene.cloud.sh[0], glm::vec3(4, 5, 6));
    EXPECT_EQ(scene.cloud.opacity_logits[0], 7);
    EXPECT_EQ(scene.cloud.log_scales[0], glm::vec3(8, 9, 10));
    EXPECT_EQ(scene.cloud.rotations[0], glm::quat(0, 1, 0, 0));
    EXPECT_THAT(scene.warnings, IsEmpty());
  }
}

TEST(Ply, every_scalar_type_is_read_in_both_byte_orders) {
  expect_type_is_read<std::int8_t>("char");
  expect_type_is_read<std::int8_t>("int8");
  expect_type_is_read<std::uint8_t>("uchar");
  expect_type_is_read<std::uint8_t>("uint8");
  expect_type_is_read<std::int16_t>("short");
  expect_type_is_read<std::int16_t>("int16");
  expect_type_is_read<std::uint16_t>("ushort");
  expect_type_is_read<std::uint16_t>("uint16");
  expect_type_is_read<std::int32_t>("int");
  expect_type_is_read<std::int32_t>("int32");
  expect_type_is_read<std::uint32_t>("uint");
  expect_type_is_read<std::uint32_t>("uint32");
  expect_type_is_read<float>("float");
  expect_type_is_read<float>("float32");
  expect_type_is_read<double>("double");
  expect_type_is_read<double>("float64");
}

TEST(Ply, sh_is_channel_major_in_every_degree) {
  for (const int degree : {0, 1, 2, 3, 4}) {
    SCOPED_TRACE(degree);
    const int rest = sh_coefficient_count(degree) - 1;
    std::string file = header("ascii", "float", kBase + rest_names(3 * rest));
    file += "0 0 0 0.1 0.2 0.3 0 -1 -1 -1 1 0 0 0";
    for (int channel = 0; channel < 3; ++channel) {
      for (int k = 0; k < rest; ++k) file += fmt::format(" {}", 100 * (channel + 1) + k);
    }
    const Scene scene = read(file);
    const int kept = std::min(degree, 3);
    ASSERT_EQ(scene.cloud.sh_degree, kept);
    for (int k = 0; k < sh_coefficient_count(kept) - 1; ++k) {
      EXPECT_EQ(scene.cloud.sh[static_cast<std::size_t>(k) + 1],
                glm::vec3(100 + k, 200 + k, 300 + k));
    }
    EXPECT_EQ(scene.warnings.size(), degree == 4 ? 1u : 0u);
  }
}

TEST(Ply, lists_inside_the_rows_are_stepped_over) {
  std::string file =
      "ply\nformat binary_big_endian 1.0\nelement vertex 2\nproperty list ushort double weights\n";
  for (const std::string& name : words_of(kBase)) file += fmt::format("property float {}\n", name);
  file += "property list uchar uchar label\nend_header\n";
  for (const int row : {1, 2}) {
    put<std::uint16_t>(file, row, true);
    for (int i = 0; i < row; ++i) put<double>(file, 99, true);
    for (const double value : {row + 0.5, 0., 0., 0., 0., 0., 0., 0., 0., 0., 1., 0., 0., 0.}) {
      put<float>(file, value, true);
    }
    file += std::string("\0", 1);
  }
  const Scene scene = read(file);
  ASSERT_EQ(scene.cloud.size(), 2u);
  EXPECT_EQ(scene.cloud.positions[0].x, 1.5f);
  EXPECT_EQ(scene.cloud.positions[1].x, 2.5f);
}

TEST(Ply, tabs_carriage_returns_and_plus_signs_are_fine) {
  std::string file = header("ascii", "\tfloat\t", kBase);
  std::string text;
  for (const char c : file) text += c == '\n' ? std::string("\t\r\n") : std::string(1, c);
  text.replace(0, text.find('\n'), "ply\r");
  const Scene scene = read(text + "+1\t2\r\n3 0 0 0 INF\n-1 -1 -inf +1e0 0 0 0\r\n");
  EXPECT_EQ(scene.cloud.positions[0], glm::vec3(1, 2, 3));
  EXPECT_EQ(scene.cloud.opacity_logits[0], INFINITY);
  EXPECT_EQ(scene.cloud.log_scales[0].z, -INFINITY);
}

TEST(Ply, missing_third_scale_is_a_flat_gaussian) {
  std::string names = kBase;
  names.erase(names.find("scale_2 "), 8);
  const Scene scene = read(header("ascii", "float", names) + "0 0 0 0 0 0 0 -1 -2 1 0 0 0");
  EXPECT_EQ(scene.cloud.log_scales[0], glm::vec3(-1, -2, -INFINITY));
  EXPECT_THAT(scene.format, HasSubstr("2D"));
}

TEST(Ply, comments_tell_of_antialiasing_and_the_vertical_axis) {
  const auto with_comment = [](const std::string& comment) {
    std::string file = header("ascii", "float", kBase);
    file.insert(file.find("element"), "comment " + comment + "\r\n");
    return read(file + "0 0 0 0 0 0 0 -1 -2 -3 1 0 0 0");
  };
  EXPECT_TRUE(with_comment("SplatRenderMode: mip").cloud.antialiased);
  EXPECT_FALSE(with_comment("SplatRenderMode: default").cloud.antialiased);
  EXPECT_TRUE(with_comment("antialiased 1").cloud.antialiased);
  EXPECT_FALSE(with_comment("antialiased 0").cloud.antialiased);
  EXPECT_EQ(with_comment("Vertical axis: -Z").vertical_axis, "-z");
  EXPECT_EQ(with_comment("nothing").vertical_axis, "");
}

TEST(Ply, tiny_and_huge_quaternions_become_unit_ones) {
  for (const std::string factor : {"1e-30", "1e-44", "1", "1e30"}) {
    const Scene scene = read(header("ascii", "float", kBase) + "0 0 0 0 0 0 0 -1 -1 -1 -" + factor +
                             " 0 " + factor + " 0");
    EXPECT_NEAR(scene.cloud.rotations[0].w, -std::sqrt(0.5), 1e-6) << factor;
    EXPECT_NEAR(scene.cloud.rotations[0].y, std::sqrt(0.5), 1e-6) << factor;
  }
}

TEST(Ply, errors_name_the_file_and_what_is_wrong) {
  const std::string good = header("ascii", "float", kBase);
  EXPECT_THAT(error_of(good + "0 0 zero"), HasSubstr("test.ply: "));
  EXPECT_THAT(error_of(good + "0 0 zero 0 0 0 0 0 0 0 0 0 0 0"), HasSubstr("'zero'"));
  EXPECT_THAT(error_of(header("ascii", "float", "x y z") + "1 2 3"), HasSubstr("point cloud"));
  EXPECT_THAT(error_of(header("ascii", "quarter", kBase)), HasSubstr("line 4: unknown type"));
  EXPECT_THAT(error_of(header("ascii", "float", "x y z f_dc_0 f_dc_2 opacity") + "0 0 0 0 0 0"),
              HasSubstr("f_dc_1"));
  EXPECT_THAT(error_of(header("ascii", "float", "x y z opacity scale_0 rot_0") + "0 0 0 0 0 0"),
              HasSubstr("f_dc_0"));
  EXPECT_THAT(error_of("ply\nformat ascii 2.0\nend_header\n"), HasSubstr("unknown format"));
}

TEST(Ply, hostile_names_do_not_reach_the_message) {
  const std::string message = error_of("ply\nformat ascii 1.0\n\x1b[2J\x07 oops\n");
  EXPECT_TRUE(std::all_of(message.begin(), message.end(), [](char c) { return c >= ' '; }));
}

TEST(Ply, more_rows_than_the_file_has_are_refused) {
  for (const char* count : {"2", "4294967297", "18446744073709551615"}) {
    std::string file = header("binary_little_endian", "float", kBase);
    file.replace(file.find("vertex 1") + 7, 1, count);
    EXPECT_THAT(error_of(file + std::string(56, '\0')), HasSubstr("announced")) << count;
  }
}

}  // namespace
}  // namespace qs::test
