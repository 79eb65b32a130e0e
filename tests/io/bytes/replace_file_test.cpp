// SPDX-License-Identifier: MIT
//
// Files that replace others, devices that must not be replaced, and disks that are full.
#include "io/bytes/replace_file.h"

#include <csignal>
#include <cstdio>
#include <fstream>
#include <future>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "base/error.h"
#include "base/temporaries.h"
#include "io/picture/image_file.h"
#include "io/scene/writer.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace {

// The requests of this program to the disk, in order; null: not recorded.
std::vector<std::string>* g_disk_log = nullptr;

}  // namespace

// These take the place of libc's functions in this program.
extern "C" int fsync(int file) {
  if (g_disk_log != nullptr) {
    const auto link = "/proc/self/fd/" + std::to_string(file);
    g_disk_log->push_back("sync " + std::filesystem::read_symlink(link).filename().string());
  }
  return static_cast<int>(syscall(SYS_fsync, file));
}
extern "C" int rename(const char* from, const char* to) noexcept {
  if (g_disk_log != nullptr)
    g_disk_log->push_back("move " + std::filesystem::path(to).filename().string());
  return static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

namespace qs {
namespace {

namespace fs = std::filesystem;
using test::error_of;
using test::without_folder;

std::string content_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t entries_in(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

// No file of this process can grow beyond `bytes` while it lives: a disk that becomes full.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &kept_);
    const rlimit small = {bytes, kept_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallDisk() {
    setrlimit(RLIMIT_FSIZE, &kept_);
    std::signal(SIGXFSZ, handler_);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

 private:
  rlimit kept_{};
  sighandler_t handler_;
};

TEST(ReplaceFile, a_disk_that_becomes_full_names_the_file_and_the_bytes) {
  const TemporaryFolder folder;
  const GaussianCloud cloud = test::random_cloud(2000, 3, 1);
  Image noise(200, 200, 3);
  std::mt19937 random(1);
  for (float& value : noise.values) value = static_cast<float>(random() % 256) / 255;
  const SmallDisk disk(8192);
  const auto says = [&](const std::string& name,
                        const std::function<void(const fs::path&)>& write) {
    const std::string said = error_of([&] { write(folder / name); }, ErrorKind::input);
    EXPECT_EQ(without_folder(said, folder.path()),
              name + ": cannot be written: File too large after 8192 bytes");
  };
  const auto picture = [&](const fs::path& path) { write_image(noise, path); };
  const auto scene = [&](const fs::path& path) { write_scene(cloud, path, test::pool(), {}); };
  for (const char* name : {"a.png", "a.ppm", "a.pfm"}) says(name, picture);
  for (const char* name : {"a.ply", "a.splat", "a.spz", "a.glb"}) says(name, scene);
  says("a.txt", [](const fs::path& path) {
    write_file(path, [](std::ostream& file) { file << std::string(100'000, 'x'); });
  });
  EXPECT_EQ(entries_in(folder.path()), 0u);
}

// After a loss of power the disk has the old file or the new one.
TEST(ReplaceFile, is_on_the_disk_before_it_replaces_another_and_so_is_its_name_at_the_end) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "models");
  const auto log_of = [](const std::function<void()>& work) {
    std::vector<std::string> log;
    g_disk_log = &log;
    work();
    g_disk_log = nullptr;
    return log;
  };
  const auto put = [](std::ostream& file) { file << "content"; };
  EXPECT_THAT(log_of([&] { write_file(folder / "models/checkpoint", put); }),
              testing::ElementsAre("sync checkpoint", "move checkpoint", "sync models"));
  const auto log = log_of([&] {
    replace_folder(folder / "models/new", [&](const fs::path& hidden) {
      write_file(hidden / "a.ply", put);
      std::ofstream(hidden / "b.txt") << "content";
    });
  });
  const std::vector<std::string> end(log.end() - 6, log.end());
  EXPECT_THAT(std::vector(end.begin(), end.begin() + 2),
              testing::UnorderedElementsAre("sync a.ply", "sync b.txt"));
  EXPECT_THAT(std::vector(end.begin() + 2, end.begin() + 4),
              testing::UnorderedElementsAre("move a.ply", "move b.txt"));
  EXPECT_THAT(std::vector(end.begin() + 4, end.end()),
              testing::ElementsAre("sync models", "sync new"));
}

// A thread may be about to open its unfinished file while the program ends.
TEST(ReplaceFile, a_program_that_ends_leaves_no_file_that_is_opened_later) {
  const TemporaryFolder folder;
  const auto ends_before_the_file_is_opened = [&] {
    std::promise<void> waits, deleted, opened;
    std::thread writer([&] {
      replace_file(folder / "late.txt", [&](const fs::path& temporary) {
        waits.set_value();
        deleted.get_future().wait();
        std::ofstream(temporary) << "late";
        opened.set_value();
      });
    });
    waits.get_future().wait();
    delete_temporaries();
    deleted.set_value();
    opened.get_future().wait();
    _exit(0);
  };
  EXPECT_EXIT(ends_before_the_file_is_opened(), testing::ExitedWithCode(0), "");
  EXPECT_EQ(entries_in(folder.path()), 0u);
}

TEST(ReplaceFile, the_longest_name_of_a_file_can_be_written) {
  const TemporaryFolder folder;
  const std::string longest(255, 'n');
  write_file(folder / longest, [](std::ostream& file) { file << "content"; });
  EXPECT_EQ(content_of(folder / longest), "content");
  EXPECT_EQ(entries_in(folder.path()), 1u);
}

TEST(ReplaceFile, a_full_device_is_written_to_and_stays) {
  const TemporaryFolder folder;
  fs::create_symlink("/dev/full", folder / "full.png");
  const std::string sentence = "full.png: cannot be written: the disk is full";
  const auto said = [&](const std::function<void()>& work) {
    return without_folder(error_of(work, ErrorKind::input), folder.path());
  };
  EXPECT_EQ(said([&] { write_image(Image(300, 300, 3), folder / "full.png"); }), sentence);
  EXPECT_EQ(said([&] {
              write_file(folder / "full.png",
                         [](std::ostream& file) { file << std::string(100'000, 'x'); });
            }),
            sentence);
  EXPECT_TRUE(fs::is_symlink(folder / "full.png"));
  EXPECT_TRUE(fs::is_character_file(folder / "full.png"));
  EXPECT_EQ(entries_in(folder.path()), 1u);
}

TEST(ReplaceFile, a_pipe_is_written_to) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] { got = content_of(folder / "pipe"); });
  write_file(folder / "pipe", [](std::ostream& file) { file << "through"; });
  reader.join();
  EXPECT_EQ(got, "through");
  EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
}

TEST(ReplaceFile, a_link_stays_and_its_file_is_replaced) {
  const TemporaryFolder folder;
  std::ofstream(folder / "file") << "old";
  fs::create_directory(folder / "links");
  fs::create_symlink("../file", folder / "links/link");
  write_file(folder / "links/link", [](std::ostream& file) { file << "new"; });
  EXPECT_TRUE(fs::is_symlink(folder / "links/link"));
  EXPECT_EQ(content_of(folder / "file"), "new");
  EXPECT_EQ(entries_in(folder / "links"), 1u);
}

TEST(ReplaceFile, a_picture_reports_how_much_of_it_is_written) {
  const TemporaryFolder folder;
  std::vector<float> seen;
  const Progress progress{[&](float fraction) { seen.push_back(fraction); }, {}};
  write_image(Image(10, 40, 3), folder / "a.png", {}, progress);
  ASSERT_FALSE(seen.empty());
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_GT(seen.size(), 30u);
  EXPECT_EQ(seen.back(), 1);
}

}  // namespace
}  // namespace qs
