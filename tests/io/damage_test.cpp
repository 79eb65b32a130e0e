// SPDX-License-Identifier: MIT
//
// Cut-off and changed files end in a scene or an Error, nothing else: no crash, no hang, no read
// beyond the end (run with the asan preset), no allocation that the file's size does not justify.
#include <algorithm>
#include <chrono>
#include <string>

#include <gtest/gtest.h>
#include <zlib.h>

#include "io/reader.h"
#include "io/spz.h"
#include "raster/scene/error.h"
#include "support/corpus.h"
#include "support/gzip.h"

namespace qs::test {
namespace {

using Bytes = std::vector<std::byte>;

// A copy of its own size per call: the address sanitizer sees every read beyond the end.
void read_any(const Bytes& bytes) {
  for (const ReaderRow& reader : readers()) {
    if (!reader.recognises(bytes, "damaged")) continue;
    Scene scene;
    scene.path = "damaged";
    try {
      reader.read(bytes, scene.path, {}, scene);
      EXPECT_GT(scene.cloud.size(), 0u);
      EXPECT_LE(scene.cloud.size(), bytes.size() * 1032);
    } catch (const Error& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("damaged: ")) << error.what();
    }
  }
}

void expect_within_limits(const Bytes& bytes) {
  const auto start = std::chrono::steady_clock::now();
  read_any(bytes);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

Bytes pass_through(const Bytes& bytes) { return bytes; }

// `repack` turns the damaged bytes into a file, so that damage reaches below a checksum.
void expect_damage_is_survived(const Bytes& bytes, Bytes (*repack)(const Bytes&) = pass_through) {
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    SCOPED_TRACE("cut to " + std::to_string(size));
    expect_within_limits(repack(Bytes(bytes.begin(), bytes.begin() + static_cast<long>(size))));
  }
  for (std::size_t at = 0; at < std::min<std::size_t>(bytes.size(), 512); ++at) {
    for (const int bits : {0xff, 0x80, 0x01}) {
      SCOPED_TRACE("byte " + std::to_string(at) + " changed by " + std::to_string(bits));
      Bytes damaged = bytes;
      damaged[at] ^= static_cast<std::byte>(bits);
      expect_within_limits(repack(damaged));
    }
  }
}

Bytes gunzip(const Bytes& bytes) {
  z_stream stream{};
  inflateInit2(&stream, 15 + 16);
  Bytes plain(1 << 20);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(plain.data());
  stream.avail_out = static_cast<uInt>(plain.size());
  inflate(&stream, Z_FINISH);
  plain.resize(stream.total_out);
  inflateEnd(&stream);
  return plain;
}

TEST(Damage, binary_ply_survives) {
  expect_damage_is_survived(file_bytes(committed_corpus() / "valid/splatapult_test.ply"));
}

TEST(Damage, ply_with_lists_survives) {
  const auto row = "3 1 2 3 0.5 1 2 0 0 0 1 -2 -2 -2 1 0 0 0\n";
  const std::string header =
      "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int vertex_indices\n"
      "element vertex 3\nproperty list uint8 float weights\nproperty float x\nproperty float y\n"
      "property float z\nproperty float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\n"
      "property double opacity\nproperty float scale_0\nproperty float scale_1\n"
      "property float scale_2\nproperty float rot_0\nproperty float rot_1\n"
      "property short rot_2\nproperty char rot_3\nend_header\n3 0 1 2\n0\n";
  const Bytes bytes = to_bytes(header + row + row + row);
  expect_damage_is_survived(bytes);
  Scene scene;
  readers()[0].read(bytes, "ascii", {}, scene);
  EXPECT_EQ(scene.cloud.size(), 3u);
  EXPECT_EQ(scene.cloud.positions[2], glm::vec3(0.5f, 1, 2));
}

TEST(Damage, compressed_ply_survives) {
  expect_damage_is_survived(file_bytes(committed_corpus() / "valid/compressed_n1.compressed.ply"));
}

TEST(Damage, spz_in_gzip_survives) {
  expect_damage_is_survived(file_bytes(committed_corpus() / "broken/spz_frac0.spz"));
}

TEST(Damage, spz_below_the_checksum_survives) {
  const Bytes plain = gunzip(file_bytes(committed_corpus() / "broken/spz_v3_ext_len_4GB.spz"));
  ASSERT_GT(plain.size(), 512u);
  expect_damage_is_survived(plain, [](const Bytes& bytes) { return gzip(bytes, 1); });
}

TEST(Damage, spz_version_2_survives) {
  const Bytes plain = gunzip(file_bytes(committed_corpus() / "broken/spz_v2_quat_overlong.spz"));
  expect_damage_is_survived(plain, [](const Bytes& bytes) { return gzip(bytes, 1); });
}

TEST(Damage, spz_version_4_survives) {
  expect_damage_is_survived(file_bytes(committed_corpus() / "broken/spz_v4_ext_past_toc.spz"));
}

TEST(Damage, small_bombs_are_refused_before_memory_is_taken) {
  Bytes plain = gunzip(file_bytes(committed_corpus() / "broken/spz_frac0.spz"));
  plain[11] = std::byte{0x17};  // 386 million Gaussians
  Scene scene;
  EXPECT_THROW(read_spz(gzip(plain, 1), "bomb", {}, scene), Error);
  EXPECT_TRUE(scene.cloud.empty());
}

}  // namespace
}  // namespace qs::test
