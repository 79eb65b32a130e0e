// SPDX-License-Identifier: MIT
#include "io/scene/writer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numeric>
#include <random>
#include <stop_token>
#include <string>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "io/cloud/cloud_memory.h"
#include "io/scene/ply/ply.h"
#include "io/scene/reader.h"
#include "raster/scene/cloud_order.h"
#include "support/corpus.h"
#include "support/pool.h"
#include "support/scene_files.h"
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

TEST(Writer, a_ply_in_parts_has_the_bytes_of_the_whole) {
  const TemporaryFolder folder;
  for (const int degree : {0, 1, 3}) {
    GaussianCloud cloud = random_cloud(1000, degree, 5);
    cloud.antialiased = degree == 1;
    write_scene(cloud, folder / "whole.ply");
    std::size_t begin = 0;
    write_ply_parts({1000, degree, cloud.antialiased}, folder / "parts.ply", pool(), [&] {
      std::vector<std::uint32_t> numbers(std::min<std::size_t>(300, 1000 - begin));
      std::iota(numbers.begin(), numbers.end(), static_cast<std::uint32_t>(begin));
      begin += numbers.size();
      return select(cloud, numbers);
    });
    EXPECT_EQ(file_bytes(folder / "parts.ply"), file_bytes(folder / "whole.ply"));
  }
}

TEST(Writer, every_row_of_the_table_writes_a_file_that_is_read_again) {
  const TemporaryFolder folder;
  const GaussianCloud cloud = random_cloud(300, 2, 3);
  for (const WriterRow& writer : writers()) {
    SCOPED_TRACE(writer.name);
    const auto path = folder / (std::string("cloud") + writer.extension);
    write_scene(cloud, path, {}, writer.name);
    EXPECT_EQ(read_scene(path).cloud.size(), cloud.size());
  }
}

// Largest errors that a format's quantisation allows for ordinary_cloud().
struct Precision {
  const char* format;
  double position, log_scale, degrees, opacity, dc, sh;
};
constexpr Precision kPrecisions[] = {
    {"compressed.ply", 0.006, 0.004, 0.25, 0.002, 0.007, 0.016},
    {"ply", 0, 0, 0.1, 0, 0, 0},
    {"spz", 1.3e-4, 0.032, 0.25, 0.002, 0.0132, 0.067},
    {"spz-v4", 1.3e-4, 0.032, 0.25, 0.002, 0.0132, 0.067},
    {"splat", 0, 1e-6, 1, 0.002, 0.007, 0},
    {"sog", 1.7e-4, 0.04, 1, 0.002, 0.012, 0.012},
    {"glb", 0, 1e-6, 0.1, 1e-6, 0, 0},
    {"usda", 0, 1e-6, 0.1, 1e-6, 0, 0},
    {"usdz", 0, 1e-6, 0.1, 1e-6, 0, 0},
};

// Values in the range that every format stores.
GaussianCloud ordinary_cloud(std::size_t count, int sh_degree) {
  std::mt19937 engine(11);
  const auto number = [&engine](float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(engine);
  };
  const auto triple = [&](float low, float high) {
    return glm::vec3(number(low, high), number(low, high), number(low, high));
  };
  GaussianCloud cloud;
  cloud.resize(count, sh_degree);
  for (glm::vec3& position : cloud.positions) position = triple(-5, 5);
  for (glm::vec3& scale : cloud.log_scales) scale = triple(-6, 0);
  for (float& logit : cloud.opacity_logits) logit = number(-4, 4);
  for (glm::vec3& value : cloud.sh) value = triple(-0.9f, 0.9f);
  for (glm::quat& q : cloud.rotations) {
    q = glm::normalize(glm::quat(number(-1, 1), number(-1, 1), number(-1, 1), number(-1, 1)));
  }
  return cloud;
}

double opacity(float logit) { return 1 / (1 + std::exp(-static_cast<double>(logit))); }

void expect_close(const glm::vec3& a, const glm::vec3& b, double tolerance, const char* what) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << what;
}

void expect_round_trip(const WriterRow& writer, const Precision& precision, int degree) {
  const TemporaryFolder folder;
  const auto path = folder / (std::string("cloud") + writer.extension);
  const GaussianCloud cloud = ordinary_cloud(700, degree);
  write_scene(cloud, path, {}, writer.name);
  const Scene scene = read_scene(path);
  EXPECT_TRUE(scene.warnings.empty());
  const std::string name = writer.name;
  const GaussianCloud expected =
      name == "splat" ? select(with_sh_degree(cloud, 0), largest_first(cloud))
      : name == "compressed.ply" || name == "sog" ? select(cloud, morton_order(cloud))
                                                  : cloud;
  const GaussianCloud& actual = scene.cloud;
  ASSERT_EQ(actual.size(), expected.size());
  ASSERT_EQ(actual.sh_degree, expected.sh_degree);
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(actual.sh_degree));
  for (std::size_t i = 0; i < actual.size(); ++i) {
    expect_close(actual.positions[i], expected.positions[i], precision.position, "position");
    expect_close(actual.log_scales[i], expected.log_scales[i], precision.log_scale, "log scale");
    EXPECT_NEAR(opacity(actual.opacity_logits[i]), opacity(expected.opacity_logits[i]),
                precision.opacity);
    const double dot = std::abs(glm::dot(actual.rotations[i], expected.rotations[i]));
    EXPECT_LE(glm::degrees(2 * std::acos(std::min(dot, 1.0))), precision.degrees);
    for (std::size_t k = 0; k < coefficients; ++k) {
      expect_close(actual.sh[i * coefficients + k], expected.sh[i * coefficients + k],
                   k == 0 ? precision.dc : precision.sh, "SH");
    }
  }
}

TEST(Writer, reading_again_gives_values_within_the_steps_of_the_format) {
  ASSERT_EQ(writers().size(), std::size(kPrecisions));
  for (std::size_t i = 0; i < writers().size(); ++i) {
    ASSERT_STREQ(writers()[i].name, kPrecisions[i].format);
    for (const int degree : {0, 1, 2, 3}) {
      SCOPED_TRACE(testing::Message() << writers()[i].name << " degree " << degree);
      expect_round_trip(writers()[i], kPrecisions[i], degree);
    }
  }
}

TEST(Writer, values_that_a_format_cannot_hold_are_brought_to_its_ends) {
  const TemporaryFolder folder;
  GaussianCloud cloud = ordinary_cloud(300, 1);
  cloud.opacity_logits[0] = INFINITY;
  cloud.opacity_logits[1] = -INFINITY;
  cloud.log_scales[2] = glm::vec3(-INFINITY, 3, 30);
  cloud.sh[4 * 3] = glm::vec3(-50, 50, 0);
  cloud.sh[4 * 3 + 1] = glm::vec3(-50, 50, 0);
  cloud.rotations[4] = glm::quat(0, 0, 0, -1);
  for (const WriterRow& writer : writers()) {
    SCOPED_TRACE(writer.name);
    const auto path = folder / (std::string("cloud") + writer.extension);
    write_scene(cloud, path, {}, writer.name);
    const Scene scene = read_scene(path);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.cloud.size(), cloud.size());
    EXPECT_EQ(
        std::count(scene.cloud.opacity_logits.begin(), scene.cloud.opacity_logits.end(), INFINITY),
        1);
  }
}

TEST(Writer, one_gaussian_is_written_in_every_format_and_none_in_no_format) {
  const TemporaryFolder folder;
  for (const WriterRow& writer : writers()) {
    for (const int degree : {0, 1, 2, 3}) {
      SCOPED_TRACE(testing::Message() << writer.name << " degree " << degree);
      const auto path = folder / (std::string("one") + writer.extension);
      const GaussianCloud one = ordinary_cloud(1, degree);
      write_scene(one, path, {}, writer.name);
      const Scene scene = read_scene(path);
      EXPECT_TRUE(scene.warnings.empty());
      ASSERT_EQ(scene.cloud.size(), 1u);
      EXPECT_EQ(scene.cloud.sh_degree, std::min(degree, writer.max_sh_degree));
      expect_close(scene.cloud.positions[0], one.positions[0], 2e-4, "position");
      expect_close(scene.cloud.sh[0], one.sh[0], 0.0132, "colour");
    }
    const auto nothing = folder / (std::string("none") + writer.extension);
    try {
      write_scene(ordinary_cloud(0, 1), nothing, {}, writer.name);
      ADD_FAILURE() << writer.name;
    } catch (const Error& error) {
      EXPECT_EQ(error.what(), nothing.string() + ": there is no Gaussian to write");
    }
    EXPECT_FALSE(std::filesystem::exists(nothing));
  }
}

TEST(Writer, spz_of_a_wide_scene_has_coarser_positions) {
  const TemporaryFolder folder;
  GaussianCloud cloud = ordinary_cloud(10, 0);
  cloud.positions[3] = glm::vec3(-30000, 12, 8);
  write_scene(cloud, folder / "cloud.spz");
  const Scene scene = read_scene(folder / "cloud.spz");
  expect_close(scene.cloud.positions[3], cloud.positions[3], 1.0 / 256, "position");
  cloud.positions[3].y = 1e9f;
  EXPECT_THROW(write_scene(cloud, folder / "cloud.spz"), Error);
}

TEST(Writer, antialiased_training_is_kept_where_the_format_can) {
  const TemporaryFolder folder;
  GaussianCloud cloud = ordinary_cloud(10, 0);
  cloud.antialiased = true;
  for (const char* name : {"a.ply", "a.compressed.ply", "a.spz"}) {
    write_scene(cloud, folder / name);
    EXPECT_TRUE(read_scene(folder / name).cloud.antialiased) << name;
  }
}

TEST(Writer, antialiased_training_is_never_lost_without_a_sentence) {
  GaussianCloud cloud = ordinary_cloud(10, 0);
  cloud.antialiased = true;
  const TemporaryFolder folder;
  for (const WriterRow& row : writers()) {
    const auto path = folder / (std::string("a") + row.extension);
    write_scene(cloud, path, {}, row.name);
    const std::string loss = row.loss == nullptr ? "" : row.loss(cloud);
    EXPECT_NE(read_scene(path).cloud.antialiased, loss.find("--antialiased on") != loss.npos)
        << row.name;
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

TEST(Writer, a_trained_scene_is_recognised_and_is_the_same_file_but_for_a_comment) {
  const TemporaryFolder folder;
  const auto text_of = [&](const char* name) {
    const auto bytes = file_bytes(folder / name);
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  const std::string comment = "comment trained by quadsplat\n";
  for (const int degree : {0, 3}) {
    const GaussianCloud cloud = random_cloud(2, degree, 3);
    write_scene(cloud, folder / "usual.ply");
    EXPECT_FALSE(is_trained_scene(folder / "usual.ply"));
    write_trained_scene(cloud, folder / "trained.ply", pool());
    EXPECT_TRUE(is_trained_scene(folder / "trained.ply")) << degree;
    std::string without = text_of("trained.ply");
    without.erase(without.find(comment), comment.size());
    EXPECT_EQ(without, text_of("usual.ply"));
  }
  std::ofstream(folder / "foreign.ply", std::ios::binary)
      << text_of("usual.ply") << comment;  // behind the header
  EXPECT_FALSE(is_trained_scene(folder / "foreign.ply"));
  std::ofstream(folder / "empty.ply") << "";
  EXPECT_FALSE(is_trained_scene(folder / "empty.ply"));
  EXPECT_FALSE(is_trained_scene(folder / "missing.ply"));
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
