// SPDX-License-Identifier: MIT
//
// Files that other programs truncate during reading: libquadsplat copies files, so it gets an error
// where a mapped file would kill the process.
#include "io/bytes/mapped_file.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/scene/reader.h"
#include "io/scene/writer.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

namespace fs = std::filesystem;

class CopiedFile : public testing::Test {
 protected:
  CopiedFile() { MappedFile::copy_files(true); }
  ~CopiedFile() override { MappedFile::copy_files(false); }

  TemporaryFolder folder_;
};

TEST_F(CopiedFile, has_the_bytes_of_the_mapped_file_and_keeps_them) {
  const fs::path path = folder_ / "a.bin";
  std::ofstream(path) << std::string(100'000, 'a') << "end";
  const MappedFile copied(path);
  MappedFile::copy_files(false);
  const MappedFile mapped(path);
  EXPECT_TRUE(std::ranges::equal(copied.content(), mapped.content()));
  fs::resize_file(path, 0);
  EXPECT_EQ(copied.content().back(), std::byte{'d'});
}

TEST_F(CopiedFile, may_be_empty) {
  std::ofstream(folder_ / "a.bin").close();
  EXPECT_TRUE(MappedFile(folder_ / "a.bin").content().empty());
}

TEST_F(CopiedFile, a_file_that_is_truncated_during_reading_is_an_error) {
  const fs::path path = folder_ / "scene.ply";
  std::ofstream(path).close();
  std::jthread other([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      fs::resize_file(path, 64 << 20);
      std::this_thread::sleep_for(std::chrono::microseconds(500));
      fs::resize_file(path, 4096);
    }
  });
  std::string error;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (error.empty() && std::chrono::steady_clock::now() < end) {
    error = error_of([&] {
      const MappedFile file(path);
      std::size_t zeros = 0;
      for (std::size_t i = 0; i < file.content().size(); i += 4096)
        zeros += file.content()[i] == std::byte{0};
      EXPECT_EQ(zeros, (file.content().size() + 4095) / 4096);
    });
  }
  EXPECT_THAT(error, testing::MatchesRegex(
                         ".*scene.ply: another program truncated it during reading: [0-9]+ of "
                         "67108864 bytes are left"));
}

TEST_F(CopiedFile, a_scene_that_shrinks_after_it_was_opened_is_read) {
  const fs::path path = folder_ / "scene.ply";
  ReadOptions options;
  bool truncated = false;
  const GaussianCloud cloud = random_cloud(10'000, 1, 1);
  write_scene(cloud, path);
  options.progress.report = [&](float) {
    if (!truncated) fs::resize_file(path, 0);
    truncated = true;
  };
  const Scene scene = qs::read_scene(path, pool(), options);
  EXPECT_TRUE(truncated);
  EXPECT_EQ(scene.cloud.positions, cloud.positions);
}

}  // namespace
}  // namespace qs::test
