// SPDX-License-Identifier: MIT
#include "io/writer.h"

#include <cmath>
#include <cstring>
#include <stop_token>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/reader.h"
#include "io/sh_degree.h"
#include "raster/scene/error.h"
#include "support/corpus.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::HasSubstr;

template <class T>
bool same_bits(const Array<T>& a, const Array<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

void expect_same(const GaussianCloud& a, const GaussianCloud& b) {
  EXPECT_EQ(a.sh_degree, b.sh_degree);
  EXPECT_EQ(a.antialiased, b.antialiased);
  EXPECT_TRUE(same_bits(a.positions, b.positions));
  EXPECT_TRUE(same_bits(a.log_scales, b.log_scales));
  EXPECT_TRUE(same_bits(a.rotations, b.rotations));
  EXPECT_TRUE(same_bits(a.opacity_logits, b.opacity_logits));
  EXPECT_TRUE(same_bits(a.sh, b.sh));
}

int entries(const std::filesystem::path& folder) {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++count;
  return count;
}

TEST(Writer, reading_again_gives_the_same_bits_in_every_degree) {
  const TemporaryFolder folder;
  for (const int degree : {0, 1, 2, 3}) {
    SCOPED_TRACE(degree);
    GaussianCloud cloud = random_cloud(5000, degree, 7);  // more than one chunk
    cloud.opacity_logits[1] = -INFINITY;
    cloud.log_scales[2] = glm::vec3(-INFINITY);
    cloud.antialiased = degree == 1;
    const auto path = folder / "cloud.ply";
    write_scene(cloud, path);
    const Scene scene = read_scene(path);
    EXPECT_TRUE(scene.warnings.empty());
    expect_same(scene.cloud, cloud);
  }
  EXPECT_EQ(entries(folder.path()), 1);
}

TEST(Writer, every_row_of_the_table_writes_a_file_that_is_read_again) {
  const TemporaryFolder folder;
  const GaussianCloud cloud = random_cloud(300, 2, 3);
  for (const WriterRow& writer : writers()) {
    SCOPED_TRACE(writer.name);
    const auto path = folder / (std::string("cloud") + writer.extension);
    write_scene(cloud, path);
    EXPECT_EQ(read_scene(path).cloud.size(), cloud.size());
  }
}

TEST(Writer, properties_are_in_the_order_of_the_original_trainer) {
  const TemporaryFolder folder;
  write_scene(random_cloud(2, 1, 3), folder / "cloud.ply");
  const auto bytes = file_bytes(folder / "cloud.ply");
  std::string expected = "ply\nformat binary_little_endian 1.0\nelement vertex 2\n";
  for (const char* name :
       {"x",        "y",        "z",        "nx",       "ny",       "nz",       "f_dc_0",
        "f_dc_1",   "f_dc_2",   "f_rest_0", "f_rest_1", "f_rest_2", "f_rest_3", "f_rest_4",
        "f_rest_5", "f_rest_6", "f_rest_7", "f_rest_8", "opacity",  "scale_0",  "scale_1",
        "scale_2",  "rot_0",    "rot_1",    "rot_2",    "rot_3"}) {
    expected += std::string("property float ") + name + "\n";
  }
  expected += "end_header\n";
  const std::string start(reinterpret_cast<const char*>(bytes.data()), expected.size());
  EXPECT_EQ(start, expected);
  EXPECT_EQ(bytes.size(), expected.size() + 2 * 26 * sizeof(float));
}

TEST(Writer, unknown_endings_are_a_usage_error) {
  const TemporaryFolder folder;
  try {
    write_scene(random_cloud(2, 1, 3), folder / "cloud.obj");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::usage);
    EXPECT_THAT(error.what(), HasSubstr(".obj"));
    EXPECT_THAT(error.what(), HasSubstr(".ply"));
  }
}

TEST(Writer, cancelled_writing_leaves_the_old_file) {
  const TemporaryFolder folder;
  const GaussianCloud old = random_cloud(10, 0, 3);
  write_scene(old, folder / "cloud.ply");
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(write_scene(random_cloud(99, 3, 4), folder / "cloud.ply", {{}, stop.get_token()}),
               Cancelled);
  expect_same(read_scene(folder / "cloud.ply").cloud, old);
  EXPECT_EQ(entries(folder.path()), 1);
}

TEST(Writer, missing_folders_are_an_input_error) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_scene(random_cloud(1, 0, 3), folder / "missing/cloud.ply"), Error);
}

TEST(ShDegree, lowering_keeps_the_first_coefficients) {
  const GaussianCloud cloud = random_cloud(10, 3, 5);
  const GaussianCloud lower = with_sh_degree(cloud, 1);
  EXPECT_EQ(lower.sh_degree, 1);
  ASSERT_EQ(lower.sh.size(), 40u);
  for (std::size_t i = 0; i < 10; ++i) {
    for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(lower.sh[4 * i + k], cloud.sh[16 * i + k]);
  }
  expect_same(with_sh_degree(cloud, 3), cloud);
  expect_same(with_sh_degree(lower, 3), lower);
}

}  // namespace
}  // namespace qs::test
