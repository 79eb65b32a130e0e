// SPDX-License-Identifier: MIT
//
// The bytes of written files, built a second time here from the formats' definitions: headers,
// offsets, order of values, rounding. A round trip alone would not notice a mistake that reader and
// writer share.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "io/scene/spz/spz_container.h"
#include "raster/scene/cloud_order.h"
#include "support/corpus.h"
#include "support/glb.h"
#include "support/gzip.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::ElementsAreArray;

class ByteText {
 public:
  template <class... T>
  void put(T... values) {
    (text_.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
  }
  void put(const glm::vec3& v) { put(v.x, v.y, v.z); }
  void text(const std::string& more) { text_ += more; }
  const std::string& str() const { return text_; }

 private:
  std::string text_;
};

std::string text_of(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The bytes of the file that the writer `format` makes of the cloud.
std::string written(const GaussianCloud& cloud, const char* format) {
  const TemporaryFolder folder;
  write_scene(cloud, folder / "scene", {}, format);
  return text_of(file_bytes(folder / "scene"));
}

void expect_same_bytes(const std::string& actual, const std::string& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  const auto place = std::mismatch(actual.begin(), actual.end(), expected.begin()).first;
  EXPECT_EQ(place, actual.end()) << "first difference at byte " << place - actual.begin();
}

std::size_t coefficients(const GaussianCloud& cloud) {
  return static_cast<std::size_t>((cloud.sh_degree + 1) * (cloud.sh_degree + 1));
}
double opacity_value(float logit) { return 1 / (1 + std::exp(-static_cast<double>(logit))); }

// To the nearest whole number, brought into 0 to `most`.
std::uint32_t rounded(double value, std::uint32_t most) {
  return static_cast<std::uint32_t>(
      std::clamp(std::floor(value + 0.5), 0.0, static_cast<double>(most)));
}
std::uint8_t byte(double value) { return static_cast<std::uint8_t>(rounded(value, 255)); }

// Gaussians of all kinds, some with values beyond the range of formats.
GaussianCloud some_cloud(std::size_t count, int degree) {
  GaussianCloud cloud = random_cloud(count, degree, 9);
  for (std::size_t i = 0; i < cloud.rotations.size(); ++i) {
    cloud.rotations[i] = glm::normalize(cloud.rotations[i]);
    if (i % 3 == 0) cloud.rotations[i] = -cloud.rotations[i];
  }
  const std::size_t n = coefficients(cloud);
  if (count > 5) {
    cloud.sh[2 * n] = {-9, 9, 0};
    cloud.opacity_logits[3] = -INFINITY;
    cloud.opacity_logits[4] = INFINITY;
    cloud.rotations[1] = {0, 0, 0, -1};
    for (std::size_t k = 1; k < n; ++k) cloud.sh[5 * n + k] = {-1.6f, 0.99f, 5.0f};
  }
  return cloud;
}

TEST(WrittenBytes, ply_has_one_row_of_floats_for_each_gaussian) {
  for (const int degree : {0, 1, 3}) {
    SCOPED_TRACE(degree);
    GaussianCloud cloud = some_cloud(70, degree);
    cloud.antialiased = degree == 1;
    const std::size_t n = coefficients(cloud);
    ByteText expected;
    expected.text("ply\nformat binary_little_endian 1.0\nelement vertex 70\n");
    const auto property = [&](const std::string& name) {
      expected.text("property float " + name + "\n");
    };
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"})
      property(name);
    for (std::size_t i = 0; i < 3 * (n - 1); ++i) property("f_rest_" + std::to_string(i));
    for (const char* name :
         {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
      property(name);
    if (cloud.antialiased) expected.text("comment SplatRenderMode: mip\n");
    expected.text("end_header\n");
    for (std::size_t i = 0; i < 70; ++i) {
      const glm::vec3* const sh = &cloud.sh[i * n];
      expected.put(cloud.positions[i]);
      expected.put(0.0f, 0.0f, 0.0f);
      expected.put(sh[0]);
      for (int channel = 0; channel < 3; ++channel) {
        for (std::size_t k = 1; k < n; ++k) expected.put(sh[k][channel]);
      }
      expected.put(cloud.opacity_logits[i]);
      expected.put(cloud.log_scales[i]);
      const glm::quat& q = cloud.rotations[i];
      expected.put(q.w, q.x, q.y, q.z);
    }
    expect_same_bytes(written(cloud, "ply"), expected.str());
  }
}

TEST(WrittenBytes, splat_has_rows_of_32_bytes_the_largest_first) {
  const GaussianCloud cloud = some_cloud(70, 1);
  ByteText expected;
  for (const std::uint32_t i : largest_first(cloud)) {
    const glm::vec3 s = cloud.log_scales[i], dc = cloud.sh[4 * i];
    expected.put(cloud.positions[i]);
    expected.put(std::exp(s.x), std::exp(s.y), std::exp(s.z));
    for (int c = 0; c < 3; ++c)
      expected.put(byte(255 * (0.5 + 0.28209479177387814 * static_cast<double>(dc[c]))));
    expected.put(byte(255 * opacity_value(cloud.opacity_logits[i])));
    const glm::quat& q = cloud.rotations[i];
    for (const float v : {q.w, q.x, q.y, q.z})
      expected.put(byte(128 * static_cast<double>(v) + 128));
  }
  expect_same_bytes(written(cloud, "splat"), expected.str());
}

struct Range {
  double low = INFINITY, high = -INFINITY;
  void include(float value) {
    low = std::min(low, static_cast<double>(value));
    high = std::max(high, static_cast<double>(value));
  }
  double share(float value) const {
    return high > low ? (static_cast<double>(value) - low) / (high - low) : 0;
  }
};
using Ranges = std::array<Range, 9>;  // of position, log scale, colour

std::array<float, 9> chunk_values(const GaussianCloud& cloud, std::size_t i) {
  std::array<float, 9> values{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    values[a] = cloud.positions[i][axis];
    values[3 + a] = std::clamp(cloud.log_scales[i][axis], -20.0f, 20.0f);
    values[6 + a] = static_cast<float>(
        0.5 + 0.28209479177387814 * static_cast<double>(cloud.sh[i * coefficients(cloud)][axis]));
  }
  return values;
}

// 2 bits for the largest component of w, x, y, z, and 10 for each of the others.
std::uint32_t packed_rotation(const glm::quat& q) {
  const std::array<float, 4> v = {q.w, q.x, q.y, q.z};
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i) largest = std::abs(v[i]) > std::abs(v[largest]) ? i : largest;
  auto bits = static_cast<std::uint32_t>(largest);
  for (std::size_t i = 0; i < 4; ++i) {
    if (i == largest) continue;
    const double value = v[largest] < 0 ? -static_cast<double>(v[i]) : static_cast<double>(v[i]);
    bits = bits * 1024 + rounded((value / std::sqrt(2.0) + 0.5) * 1023, 1023);
  }
  return bits;
}

std::string expected_compressed_ply(const GaussianCloud& cloud) {
  const std::size_t n = coefficients(cloud), chunks = (cloud.size() + 255) / 256;
  const std::string count = std::to_string(cloud.size());
  ByteText expected, rows, sh;
  expected.text("ply\nformat binary_little_endian 1.0\nelement chunk " + std::to_string(chunks) +
                "\n");
  for (const char* name : {"min_x", "min_y", "min_z", "max_x", "max_y", "max_z", "min_scale_x",
                           "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y",
                           "max_scale_z", "min_r", "min_g", "min_b", "max_r", "max_g", "max_b"})
    expected.text("property float " + std::string(name) + "\n");
  expected.text("element vertex " + count +
                "\nproperty uint packed_position\nproperty uint packed_rotation\n"
                "property uint packed_scale\nproperty uint packed_color\n");
  if (n > 1) expected.text("element sh " + count + "\n");
  for (std::size_t i = 0; i < 3 * (n - 1); ++i)
    expected.text("property uchar f_rest_" + std::to_string(i) + "\n");
  if (cloud.antialiased) expected.text("comment SplatRenderMode: mip\n");
  expected.text("end_header\n");

  const auto order = morton_order(cloud);
  for (std::size_t first = 0; first < order.size(); first += 256) {
    const std::size_t end = std::min(first + 256, order.size());
    Ranges ranges;
    for (std::size_t i = first; i < end; ++i) {
      for (std::size_t v = 0; v < 9; ++v) ranges[v].include(chunk_values(cloud, order[i])[v]);
    }
    for (const std::size_t group : {0u, 3u, 6u}) {
      for (std::size_t v = group; v < group + 3; ++v)
        expected.put(static_cast<float>(ranges[v].low));
      for (std::size_t v = group; v < group + 3; ++v)
        expected.put(static_cast<float>(ranges[v].high));
    }
    for (std::size_t i = first; i < end; ++i) {
      const auto values = chunk_values(cloud, order[i]);
      const auto step = [&](std::size_t v, std::uint32_t most) {
        return rounded(ranges[v].share(values[v]) * most, most);
      };
      const auto triple = [&](std::size_t v) {
        return step(v, 2047) << 21 | step(v + 1, 1023) << 11 | step(v + 2, 2047);
      };
      rows.put(triple(0), packed_rotation(cloud.rotations[order[i]]), triple(3),
               step(6, 255) << 24 | step(7, 255) << 16 | step(8, 255) << 8 |
                   rounded(255 * opacity_value(cloud.opacity_logits[order[i]]), 255));
      for (int channel = 0; channel < 3; ++channel) {
        for (std::size_t k = 1; k < n; ++k) {
          const double value = static_cast<double>(cloud.sh[order[i] * n + k][channel]);
          sh.put(static_cast<std::uint8_t>(std::clamp(std::floor(32 * (value + 4)), 0.0, 255.0)));
        }
      }
    }
  }
  return expected.str() + rows.str() + sh.str();
}

TEST(WrittenBytes, compressed_ply_quantises_within_chunks_of_256) {
  for (const int degree : {0, 1, 2}) {
    SCOPED_TRACE(degree);
    GaussianCloud cloud = some_cloud(300, degree);
    cloud.antialiased = degree == 2;
    for (glm::vec3& position : cloud.positions) position.y = 0.25f;  // a flat box
    cloud.log_scales[7] = glm::vec3(-INFINITY, 30, 0);
    expect_same_bytes(written(cloud, "compressed.ply"), expected_compressed_ply(cloud));
  }
  expect_same_bytes(written(some_cloud(256, 1), "compressed.ply"),
                    expected_compressed_ply(some_cloud(256, 1)));
}

// True for coefficients that are odd in y or z but not both, so that the half turn about x changes
// their sign.
constexpr bool kOddInYOrZ[] = {false, true, true,  false, true, false, false, true,
                               false, true, false, true,  true, false, true,  false};

std::string expected_spz_blocks(const GaussianCloud& cloud, int bits) {
  const std::size_t n = coefficients(cloud);
  ByteText positions, alphas, colors, scales, rotations, sh;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 up = cloud.positions[i] * glm::vec3(1, -1, -1);
    for (int axis = 0; axis < 3; ++axis) {
      const auto fixed =
          static_cast<std::int32_t>(std::round(static_cast<double>(up[axis]) * std::exp2(bits)));
      for (int k = 0; k < 3; ++k)
        positions.put(static_cast<std::uint8_t>(static_cast<std::uint32_t>(fixed) >> (8 * k)));
    }
    alphas.put(byte(255 * opacity_value(cloud.opacity_logits[i])));
    for (int c = 0; c < 3; ++c) {
      colors.put(byte(255 * (0.15 * static_cast<double>(cloud.sh[i * n][c]) + 0.5)));
      scales.put(byte(16 * (static_cast<double>(cloud.log_scales[i][c]) + 10)));
    }
    const glm::quat& q = cloud.rotations[i];
    const std::array<float, 4> v = {q.x, -q.y, -q.z, q.w};
    std::size_t largest = 0;
    for (std::size_t k = 1; k < 4; ++k)
      largest = std::abs(v[k]) > std::abs(v[largest]) ? k : largest;
    auto packed = static_cast<std::uint32_t>(largest);
    for (std::size_t k = 0; k < 4; ++k) {
      if (k == largest) continue;
      const bool negative = (v[largest] < 0 ? -v[k] : v[k]) < 0;
      packed = packed * 1024 + (negative ? 512 : 0) +
               rounded(std::abs(static_cast<double>(v[k])) * std::sqrt(2.0) * 511, 511);
    }
    rotations.put(packed);
    for (std::size_t k = 1; k < n; ++k) {
      for (int c = 0; c < 3; ++c) {
        const double value = static_cast<double>(cloud.sh[i * n + k][c]) * (kOddInYOrZ[k] ? -1 : 1);
        const double step = k < 4 ? 8 : 16, exact = std::round(128 * value) + 128;
        sh.put(static_cast<std::uint8_t>(
            std::clamp(step * std::floor(exact / step + 0.5), 0.0, 255.0)));
      }
    }
  }
  return positions.str() + alphas.str() + colors.str() + scales.str() + rotations.str() + sh.str();
}

std::string spz_start(const GaussianCloud& cloud, std::uint32_t version, int bits) {
  ByteText start;
  start.text("NGSP");
  start.put(version, static_cast<std::uint32_t>(cloud.size()),
            static_cast<std::uint8_t>(cloud.sh_degree), static_cast<std::uint8_t>(bits),
            static_cast<std::uint8_t>(cloud.antialiased ? 1 : 0));
  return start.str();
}

// Clouds whose widest positions need these fractional bits.
std::vector<std::pair<GaussianCloud, int>> spz_clouds() {
  std::vector<std::pair<GaussianCloud, int>> clouds;
  for (const int degree : {0, 1, 3}) clouds.emplace_back(some_cloud(90, degree), 12);
  clouds[1].first.antialiased = true;
  for (glm::vec3& position : clouds[2].first.positions) position.x += 0.3f;
  const auto with = [&](glm::vec3 position, int bits) {
    GaussianCloud cloud = some_cloud(3, 0);
    cloud.positions = {{1, 2, 3}, position, {-1, 0.5f, 4}};
    clouds.emplace_back(cloud, bits);
  };
  with({2047.5f, 1, 1}, 12);
  with({2048, 1, 1}, 11);
  with({1, -4095.9f, 1}, 11);
  with({1, 1, 8388607}, 0);
  return clouds;
}

TEST(WrittenBytes, spz_has_a_header_and_blocks_in_gzip) {
  for (const auto& [cloud, bits] : spz_clouds()) {
    SCOPED_TRACE(testing::Message()
                 << cloud.size() << ", degree " << cloud.sh_degree << ", " << bits);
    const std::string plain = gunzip(written(cloud, "spz"));
    expect_same_bytes(plain, spz_start(cloud, 3, bits) + '\0' + expected_spz_blocks(cloud, bits));
  }
}

TEST(WrittenBytes, spz_of_version_4_has_a_table_of_streams_after_32_bytes) {
  ThreadPool pool(1);
  for (const auto& [cloud, bits] : spz_clouds()) {
    SCOPED_TRACE(testing::Message()
                 << cloud.size() << ", degree " << cloud.sh_degree << ", " << bits);
    const TemporaryFolder folder;
    write_scene(cloud, folder / "a.spz", {}, "spz-v4");
    const auto bytes = file_bytes(folder / "a.spz");
    const std::uint8_t streams = cloud.sh_degree == 0 ? 5 : 6;
    ByteText header;
    header.text(spz_start(cloud, 4, bits));
    header.put(streams, std::uint32_t{32});
    header.text(std::string(12, '\0'));
    ASSERT_GT(bytes.size(), 32 + 16u * streams);
    expect_same_bytes(text_of(bytes).substr(0, 32), header.str());
    const auto number = [&](std::size_t at) {
      std::uint64_t value = 0;
      std::memcpy(&value, bytes.data() + at, 8);
      return value;
    };
    const std::size_t rest = 3 * (coefficients(cloud) - 1);
    const std::size_t row_bytes[] = {9, 1, 3, 3, 4, rest};
    std::size_t total = 32 + 16u * streams;
    for (std::size_t i = 0; i < streams; ++i) {
      total += number(32 + 16 * i);
      EXPECT_EQ(number(32 + 16 * i + 8), row_bytes[i] * cloud.size());
    }
    EXPECT_EQ(bytes.size(), total);
    const SpzContent content =
        unpack_spz(bytes, folder / "a.spz", pool, {}, 1, [](const SpzContent&) {});
    const std::string blocks(reinterpret_cast<const char*>(content.bytes.data()),
                             content.bytes.size());
    expect_same_bytes(blocks, expected_spz_blocks(cloud, bits));
  }
}

TEST(WrittenBytes, spz_cannot_hold_positions_beyond_24_bits) {
  GaussianCloud cloud = some_cloud(3, 0);
  cloud.positions[1] = {1, 1, 8388608};
  for (const char* format : {"spz", "spz-v4"}) {
    try {
      written(cloud, format);
      ADD_FAILURE() << format;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("/scene: .spz cannot hold positions beyond "
                                                   "8388607, there is one at 8388608"));
    }
  }
}

TEST(WrittenBytes, glb_describes_the_floats_that_follow) {
  for (const int degree : {0, 1, 3}) {
    SCOPED_TRACE(degree);
    const GaussianCloud cloud = some_cloud(70, degree);
    const std::size_t n = coefficients(cloud), count = cloud.size();
    const std::string file = written(cloud, "glb");
    std::vector<float> columns;
    std::vector<std::pair<std::string, std::size_t>> attributes = {
        {"POSITION", 3},
        {"KHR_gaussian_splatting:ROTATION", 4},
        {"KHR_gaussian_splatting:SCALE", 3},
        {"KHR_gaussian_splatting:OPACITY", 1}};
    for (int l = 0; l <= degree; ++l) {
      for (int k = 0; k < 2 * l + 1; ++k)
        attributes.emplace_back(
            "KHR_gaussian_splatting:SH_DEGREE_" + std::to_string(l) + "_COEF_" + std::to_string(k),
            3);
    }
    const auto add = [&](glm::vec3 v) { columns.insert(columns.end(), {v.x, v.y, v.z}); };
    glm::vec3 low(INFINITY), high(-INFINITY);
    for (const glm::vec3& p : cloud.positions) {
      add(p * glm::vec3(-1, -1, 1));
      low = glm::min(low, p * glm::vec3(-1, -1, 1));
      high = glm::max(high, p * glm::vec3(-1, -1, 1));
    }
    for (const glm::quat& q : cloud.rotations)
      columns.insert(columns.end(), {-q.x, -q.y, q.z, q.w});
    for (const glm::vec3& s : cloud.log_scales) add(glm::vec3(glm::exp(glm::dvec3(s))));
    for (const float logit : cloud.opacity_logits)
      columns.push_back(static_cast<float>(opacity_value(logit)));
    // Odd in x or y but not both.
    constexpr bool kOdd[] = {false, true, false, true, false, true, false, true,
                             false, true, false, true, false, true, false, true};
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t i = 0; i < count; ++i) add(cloud.sh[i * n + k] * (kOdd[k] ? -1.0f : 1.0f));
    }

    using nlohmann::ordered_json;
    ordered_json names = ordered_json::object(), accessors = ordered_json::array(),
                 views = ordered_json::array();
    std::size_t offset = 0;
    const char* const types[] = {"", "SCALAR", "", "VEC3", "VEC4"};
    for (const auto& [name, components] : attributes) {
      names[name] = accessors.size();
      accessors.push_back({{"bufferView", views.size()},
                           {"componentType", 5126},
                           {"count", count},
                           {"type", types[components]}});
      views.push_back({{"buffer", 0},
                       {"byteOffset", offset},
                       {"byteLength", 4 * count * components},
                       {"target", 34962}});
      offset += 4 * count * components;
    }
    accessors[0]["min"] = {low.x, low.y, low.z};
    accessors[0]["max"] = {high.x, high.y, high.z};
    const ordered_json description = {{"asset", {{"version", "2.0"}, {"generator", "quadsplat"}}},
                                      {"extensionsUsed", {"KHR_gaussian_splatting"}},
                                      {"scene", 0},
                                      {"scenes", {{{"nodes", {0}}}}},
                                      {"nodes", {{{"mesh", 0}}}},
                                      {"meshes",
                                       {{{"primitives",
                                          {{{"attributes", names},
                                            {"mode", 0},
                                            {"extensions",
                                             {{"KHR_gaussian_splatting",
                                               {{"kernel", "ellipse"},
                                                {"colorSpace", "srgb_rec709_display"},
                                                {"projection", "perspective"},
                                                {"sortingMethod", "cameraDistance"}}}}}}}}}}},
                                      {"accessors", accessors},
                                      {"bufferViews", views},
                                      {"buffers", {{{"byteLength", offset}}}}};
    std::string text = description.dump();
    while (text.size() % 4 != 0) text += ' ';
    ByteText expected;
    expected.text("glTF");
    expected.put(std::uint32_t{2}, static_cast<std::uint32_t>(28 + text.size() + offset),
                 static_cast<std::uint32_t>(text.size()));
    expected.text("JSON" + text);
    expected.put(static_cast<std::uint32_t>(offset));
    expected.text(std::string("BIN\0", 4));
    ASSERT_GE(file.size(), expected.str().size());
    expect_same_bytes(file.substr(0, expected.str().size()), expected.str());
    ASSERT_EQ(file.size(), expected.str().size() + 4 * columns.size());
    ASSERT_EQ(4 * columns.size(), offset);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      float value = 0;
      std::memcpy(&value, file.data() + expected.str().size() + 4 * i, 4);
      ASSERT_FLOAT_EQ(value, columns[i]) << i;
    }
  }
}

// Files are written in pieces, and each piece is reported once.
TEST(WrittenBytes, progress_follows_the_pieces_of_a_file) {
  constexpr float n = 40000, piece = 32768, part = 16384;
  const std::pair<const char*, std::vector<float>> expected[] = {
      {"ply", {0, piece / n, 1}},
      {"splat", {piece / n, 1}},
      {"compressed.ply", {0.3f, 0.6f, 1}},
      {"spz",
       {0, 0.5f * part / n, 0.5f * 2 * part / n, 0.58f, 0.66f, 0.74f, 0.82f, 0.9f, 0.98f, 1}},
      {"spz-v4", {0, 0.5f * part / n, 0.5f * 2 * part / n, 0.58f, 0.66f, 0.74f, 0.82f, 0.9f, 1}},
      {"sog", {0, 0.2f, 0.6f, 1}},
      {"glb", {0, 0.2f, 0.4f, 0.6f, 0.8f, 1}},
      {"usda", {0, 0.1f, 0.2f, 0.3f, 0.4f, 0.9f, 1}},
      {"usdz", {0, 0.1f, 0.2f, 0.3f, 0.4f, 0.9f, 1}},
  };
  const TemporaryFolder folder;
  const GaussianCloud cloud = random_cloud(40000, 0, 3);
  ASSERT_EQ(std::size(expected), writers().size());
  for (const auto& [format, fractions] : expected) {
    SCOPED_TRACE(format);
    std::vector<float> reported;
    const Progress progress{[&](float fraction) { reported.push_back(fraction); }, {}};
    write_scene(cloud, folder / "a", progress, format);
    EXPECT_THAT(reported, testing::Pointwise(testing::FloatNear(1e-6f), fractions));
    EXPECT_EQ(read_scene(folder / "a").cloud.size(), cloud.size());
  }
  write_scene(cloud, folder / "a", {}, "ply");
  EXPECT_EQ(read_scene(folder / "a").cloud.positions, cloud.positions);
  write_scene(cloud, folder / "a", {}, "splat");
  EXPECT_EQ(read_scene(folder / "a").cloud.positions,
            select(cloud, largest_first(cloud)).positions);
}

}  // namespace
}  // namespace qs::test
