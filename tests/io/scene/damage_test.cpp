// SPDX-License-Identifier: MIT
//
// Truncated and changed files lead to a scene or an Error within the limits of io/support/limits.h:
// no crash, no hang, and under the asan preset no read beyond the end.
#include <algorithm>
#include <cstring>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "base/error.h"
#include "io/scene/reader.h"
#include "io/scene/splat/splat.h"
#include "io/scene/writer.h"
#include "io/support/limits.h"
#include "support/corpus.h"
#include "support/gzip.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using Bytes = std::vector<std::byte>;

// The allowed outcomes: a scene of at most `max_count` Gaussians, or an Error that names `path`.
void expect_sound(const std::filesystem::path& path, std::size_t max_count,
                  const std::function<Scene()>& read) {
  expect_within_limits([&]() -> std::size_t {
    try {
      const Scene scene = read();
      EXPECT_GT(scene.cloud.size(), 0u);
      EXPECT_LE(scene.cloud.size(), max_count);
      return bytes_of(scene.cloud);
    } catch (const Error& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(path.string())) << error.what();
      return 0;
    }
  });
}

// `bytes` has exactly its own size, so AddressSanitizer detects every read beyond the end.
void expect_sound(const Bytes& bytes) {
  for (const ReaderRow& reader : readers()) {
    if (!reader.recognises(bytes, "damaged")) continue;
    expect_sound("damaged: ", bytes.size() * 1032, [&] {
      Scene scene;
      scene.path = "damaged";
      ThreadPool pool(1);
      reader.read(bytes, scene.path, pool, {}, scene);
      return scene;
    });
  }
}

void expect_sound_scene(const std::filesystem::path& path, std::size_t max_count) {
  expect_sound(path, max_count, [&] { return read_scene(path); });
}

Bytes pass_through(const Bytes& bytes) { return bytes; }

// `repack` makes a file of the damaged bytes, to damage data below a checksum.
void expect_damage_is_survived(const Bytes& bytes, Bytes (*repack)(const Bytes&) = pass_through) {
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    SCOPED_TRACE("cut to " + std::to_string(size));
    expect_sound(repack(Bytes(bytes.begin(), bytes.begin() + static_cast<long>(size))));
  }
  for (std::size_t at = 0; at < std::min<std::size_t>(bytes.size(), 512); ++at) {
    for (const int bits : {0xff, 0x80, 0x01}) {
      SCOPED_TRACE("byte " + std::to_string(at) + " changed by " + std::to_string(bits));
      Bytes damaged = bytes;
      damaged[at] ^= static_cast<std::byte>(bits);
      expect_sound(repack(damaged));
    }
  }
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
  ThreadPool pool(2);
  readers()[0].read(bytes, "ascii", pool, {}, scene);
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

TEST(Damage, splat_survives) {
  Bytes bytes = file_bytes(committed_corpus() / "valid/splat_sh0.splat");
  bytes.resize(20 * 32);
  expect_damage_is_survived(bytes);
}

// A section of five Gaussians in two buckets, one full and one not.
TEST(Damage, ksplat_survives) {
  constexpr std::size_t kHeaders = 4096 + 1024;
  Bytes bytes(kHeaders + 4 + 2 * 12 + 5 * (24 + 24), std::byte{0x3c});
  std::fill_n(bytes.begin(), kHeaders, std::byte{0});
  const auto put = [&bytes](std::size_t at, auto value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
  };
  put(1, std::uint8_t{1});
  for (const std::size_t at : {4u, 8u}) put(at, 1u);    // sections
  for (const std::size_t at : {12u, 16u}) put(at, 5u);  // Gaussians
  put(20, std::uint16_t{2});                            // level
  for (const std::size_t at : {0u, 4u}) put(4096 + at, 5u);
  put(4096 + 8, 3u);     // rows of a bucket
  put(4096 + 12, 2u);    // buckets
  put(4096 + 16, 5.0f);  // their size
  put(4096 + 20, std::uint16_t{12});
  put(4096 + 32, 1u);                // full buckets
  put(4096 + 36, 1u);                // partial buckets
  put(4096 + 40, std::uint16_t{2});  // SH degree
  put(kHeaders, 2u);
  for (const std::size_t at : {4u, 8u, 12u, 16u, 20u, 24u}) put(kHeaders + at, 1.0f);
  Scene scene;
  ThreadPool pool(2);
  read_ksplat(bytes, "damaged", pool, {}, scene);
  EXPECT_EQ(scene.cloud.size(), 5u);
  expect_damage_is_survived(bytes);
  // The section's header lies beyond the first 512 bytes.
  for (std::size_t at = 4096; at < 4096 + 48; ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      SCOPED_TRACE("byte " + std::to_string(at) + " bit " + std::to_string(bit));
      Bytes damaged = bytes;
      damaged[at] ^= static_cast<std::byte>(1 << bit);
      expect_sound(damaged);
    }
  }
}

TEST(Damage, sog_archive_survives) {
  expect_damage_is_survived(file_bytes(committed_corpus() / "valid/sog_v1_zipped.sog"));
}

// Every 97th truncation, because each copy has the whole network.
TEST(Damage, compact_npz_survives) {
  const Bytes bytes = file_bytes(committed_corpus() / "valid/compact_small_pp.npz");
  for (std::size_t size = 0; size < bytes.size(); size += 97) {
    SCOPED_TRACE("cut to " + std::to_string(size));
    expect_sound(Bytes(bytes.begin(), bytes.begin() + static_cast<long>(size)));
  }
  for (std::size_t at = 0; at < bytes.size(); at += at < 512 ? 1 : 97) {
    SCOPED_TRACE("byte " + std::to_string(at));
    Bytes damaged = bytes;
    damaged[at] ^= std::byte{0x11};
    expect_sound(damaged);
  }
}

TEST(Damage, sog_folder_survives) {
  const TemporaryFolder folder;
  const auto scene_file = folder / "sog/meta.json";
  std::filesystem::copy(committed_corpus() / "valid/sog_v1_folder", folder / "sog");
  for (const auto& entry : std::filesystem::directory_iterator(folder / "sog")) {
    std::filesystem::permissions(entry, std::filesystem::perms::owner_all);
    const Bytes bytes = file_bytes(entry.path());
    const auto read = [&](const Bytes& damaged, std::size_t at) {
      SCOPED_TRACE(entry.path().filename().string() + " at " + std::to_string(at));
      write_bytes(entry.path(), damaged);
      expect_sound_scene(scene_file, 16000 * 8);
    };
    const bool is_text = entry.path() == scene_file;  // pictures have checksums
    for (std::size_t at = 0; at < std::min<std::size_t>(bytes.size(), 512); at += is_text ? 1 : 8) {
      read(Bytes(bytes.begin(), bytes.begin() + static_cast<long>(at)), at);
      Bytes damaged = bytes;
      damaged[at] ^= std::byte{0x11};
      read(damaged, at);
    }
    write_bytes(entry.path(), bytes);
  }
  EXPECT_EQ(read_scene(scene_file).cloud.size(), 900u);
}

TEST(Damage, streamed_sog_survives) {
  const TemporaryFolder folder;
  const auto scene_file = folder / "tree/lod-meta.json";
  std::filesystem::copy(committed_corpus() / "valid/lod_of_sog_v1", folder / "tree",
                        std::filesystem::copy_options::recursive);
  std::filesystem::permissions(scene_file, std::filesystem::perms::owner_all);
  const Bytes bytes = file_bytes(scene_file);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const bool cut : {false, true}) {
      SCOPED_TRACE("byte " + std::to_string(at) + (cut ? " cut" : " changed"));
      Bytes damaged(bytes.begin(), bytes.begin() + static_cast<long>(cut ? at : bytes.size()));
      if (!cut) damaged[at] ^= std::byte{0x01};
      write_bytes(scene_file, damaged);
      expect_sound_scene(scene_file, 900);
    }
  }
}

TEST(Damage, glb_survives) {
  const TemporaryFolder folder;
  write_scene(random_cloud(3, 1, 1), folder / "a.glb");
  const Bytes bytes = file_bytes(folder / "a.glb");
  expect_damage_is_survived(bytes);
  // All of the description.
  for (std::size_t at = 512; at < bytes.size(); ++at) {
    SCOPED_TRACE("byte " + std::to_string(at));
    Bytes damaged = bytes;
    damaged[at] ^= std::byte{0x01};
    expect_sound(damaged);
  }
}

TEST(Damage, usd_text_survives) {
  const Bytes bytes = file_bytes(committed_corpus() / "valid/usd_stage.usda");
  expect_damage_is_survived(bytes);
  for (std::size_t at = 512; at < bytes.size(); ++at) {
    for (const char c : {'0', '(', ']', '"', '\n', '@', '=', '\0'}) {
      SCOPED_TRACE("byte " + std::to_string(at) + " is " + std::string(1, c));
      Bytes damaged = bytes;
      damaged[at] = static_cast<std::byte>(c);
      expect_sound(damaged);
    }
  }
}

TEST(Damage, usd_archive_survives) {
  expect_damage_is_survived(file_bytes(committed_corpus() / "valid/usd_z_up.usdz"));
}

TEST(Damage, gltf_with_compressed_gaussians_survives) {
  Bytes bytes = file_bytes(committed_corpus() / "broken/glb_spz2_version3_blob.glb");
  expect_damage_is_survived(bytes);
}

}  // namespace
}  // namespace qs::test
