// SPDX-License-Identifier: MIT
//
// Zip archives, against libzip.
#include "io/bytes/zip.h"

#include <cstring>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/fail.h"
#include "io/support/zip_archive.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::vector<ZipEntry> kEntries = {{"folder/a.txt", "some words, some words, some words"},
                                        {"empty", ""},
                                        {"\xc3\xa4.bin", std::string(100000, 'x')}};

ZipEntries contents(std::span<const std::byte> archive) {
  ZipEntries read;
  for (const ZippedFile& file : zip_directory(archive, "a.zip")) {
    const Array<std::byte> bytes = unzipped(file, "a.zip");
    read.emplace_back(file.name,
                      std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
  return read;
}

std::string error_in(std::span<const std::byte> archive) {
  return error_of([&] { contents(archive); });
}

ZipEntries expected() {
  ZipEntries entries;
  for (const ZipEntry& entry : kEntries) entries.emplace_back(entry.name, entry.content);
  return entries;
}

std::vector<std::byte> written(bool deflated, const std::vector<ZipEntry>& entries = kEntries) {
  const TemporaryFolder folder;
  qs::write_zip(folder / "a.zip", entries, deflated ? ZipForm::deflated : ZipForm::stored);
  return file_bytes(folder / "a.zip");
}

template <class T>
void set(std::vector<std::byte>& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

TEST(Zip, written_archives_are_read_by_libzip_and_by_the_reader) {
  const TemporaryFolder folder;
  for (const bool deflated : {false, true}) {
    qs::write_zip(folder / "a.zip", kEntries, deflated ? ZipForm::deflated : ZipForm::stored);
    EXPECT_EQ(zip_entries(folder / "a.zip"), expected());
    EXPECT_EQ(contents(file_bytes(folder / "a.zip")), expected());
  }
  EXPECT_LT(written(true).size(), 1000u);
  EXPECT_EQ(contents(written(true, {})), ZipEntries());
  EXPECT_EQ(written(true), written(true));
}

TEST(Zip, archives_of_libzip_are_read) {
  const TemporaryFolder folder;
  for (const bool deflated : {false, true}) {
    write_zip(folder / "a.zip", expected(), deflated);
    EXPECT_EQ(contents(file_bytes(folder / "a.zip")), expected());
  }
}

// The sizes, the place and the directory's end in 64 bits, as PyTorch and numpy write them.
std::vector<std::byte> archive_in_64_bits() {
  const std::vector<ZipEntry> entries = {{"a", "12345"}};
  std::vector<std::byte> plain = written(false, entries);
  constexpr std::size_t kLocal = 30 + 1, kCentral = 46 + 1;
  std::vector<std::byte> made(plain.begin(), plain.begin() + kLocal);
  const auto add = [&](auto... values) {
    const auto one = [&](auto value) {
      const auto* bytes = reinterpret_cast<const std::byte*>(&value);
      made.insert(made.end(), bytes, bytes + sizeof value);
    };
    (one(values), ...);
  };
  using U16 = std::uint16_t;
  using U32 = std::uint32_t;
  using U64 = std::uint64_t;
  set(made, 18, U32{0xffffffff});
  set(made, 22, U32{0xffffffff});
  set(made, 28, U16{20});
  add(U16{1}, U16{16}, U64{5}, U64{5});
  made.insert(made.end(), plain.begin() + kLocal, plain.begin() + kLocal + 5);
  const std::size_t directory = made.size();
  const auto central = plain.begin() + kLocal + 5;
  made.insert(made.end(), central, central + kCentral);
  for (const std::size_t at : {20u, 24u, 42u}) set(made, directory + at, U32{0xffffffff});
  set(made, directory + 30, U16{4 + 2 + 28});
  add(U16{7}, U16{2}, U16{0}, U16{1}, U16{24}, U64{5}, U64{5}, U64{0});
  const std::size_t end64 = made.size();
  add(U32{0x06064b50}, U64{44}, U16{45}, U16{45}, U32{0}, U32{0}, U64{1}, U64{1},
      U64{end64 - directory}, U64{directory});
  add(U32{0x07064b50}, U32{0}, U64{end64}, U32{1});
  add(U32{0x06054b50}, U16{0}, U16{0}, U16{0xffff}, U16{0xffff}, U32{0xffffffff}, U32{0xffffffff},
      U16{0});
  return made;
}

TEST(Zip, archives_in_64_bits_are_read) {
  const TemporaryFolder folder;
  const std::vector<std::byte> archive = archive_in_64_bits();
  write_bytes(folder / "a.zip", archive);
  const ZipEntries one = {{"a", "12345"}};
  ASSERT_EQ(zip_entries(folder / "a.zip"), one);
  EXPECT_EQ(contents(archive), one);
}

TEST(Zip, any_cut_and_any_changed_byte_is_found_or_changes_no_content) {
  for (const std::vector<std::byte>& sound : {written(true), archive_in_64_bits()}) {
    const ZipEntries read = contents(sound);
    for (std::size_t size = 0; size < sound.size(); ++size)
      EXPECT_THAT(error_in(std::span(sound).first(size)), StartsWith("a.zip: ")) << size;
    std::vector<std::byte> damaged = sound;
    for (std::size_t at = 0; at < sound.size(); ++at) {
      for (const int flip : {1, 0x80, 0xff}) {
        damaged[at] ^= static_cast<std::byte>(flip);
        ZipEntries other;
        const std::string error = error_of([&] { other = contents(damaged); });
        if (error.empty()) {
          ASSERT_TRUE(other == read) << at;
        } else {
          ASSERT_THAT(error, StartsWith("a.zip: ")) << at;
        }
        damaged[at] = sound[at];
      }
    }
  }
}

TEST(Zip, unsound_archives_are_refused_in_a_sentence) {
  const std::vector<ZipEntry> two = {{"a", "12345"}, {"b", "12345"}};
  const std::vector<std::byte> sound = written(false, two);
  constexpr std::size_t kDirectory = 2 * (30 + 1 + 5), kCentral = 46 + 1;
  const auto error_with = [&](std::size_t at, auto value) {
    std::vector<std::byte> changed = sound;
    set(changed, at, value);
    return error_in(changed);
  };
  EXPECT_EQ(error_in(sound), "");
  EXPECT_EQ(error_in({}), "a.zip: not a sound zip archive (cut off)");
  EXPECT_EQ(error_in(std::vector<std::byte>(99)),
            "a.zip: not a sound zip archive (no end of its directory)");
  const std::size_t end = sound.size() - 22;
  EXPECT_EQ(error_with(end + 10, std::uint16_t{9}),
            "a.zip: not a sound zip archive (its directory is too small for its files)");
  EXPECT_EQ(error_with(end + 16, std::uint32_t{99999}),
            "a.zip: not a sound zip archive (its directory is outside of the file)");
  EXPECT_EQ(error_with(kDirectory + 42, std::uint32_t{99999}),
            "a.zip: not a sound zip archive (a file is outside of it)");
  EXPECT_EQ(error_with(kDirectory + 24, std::uint32_t{6}),
            "a.zip: not a sound zip archive (a file's header is not as in its directory)");
  // Both entries of the directory name the first file.
  std::vector<std::byte> same = sound;
  set(same, 30, 'a');
  set(same, kDirectory + kCentral + 46, 'a');
  set(same, kDirectory + kCentral + 42, std::uint32_t{0});
  EXPECT_EQ(error_in(same), "a.zip: not a sound zip archive (files overlap)");
}

TEST(Zip, files_that_cannot_be_unpacked_are_refused_in_a_sentence) {
  const std::vector<ZipEntry> one = {{"a", "12345"}};
  constexpr std::size_t kDirectory = 30 + 1 + 5;
  std::vector<std::byte> changed = written(false, one);
  set(changed, 31, '9');
  EXPECT_EQ(error_in(changed), "a.zip: a is damaged (its checksum is wrong)");
  changed = written(false, one);
  set(changed, kDirectory + 8, std::uint16_t{1});
  EXPECT_EQ(error_in(changed), "a.zip: a is encrypted");
  changed = written(false, one);
  for (const std::size_t at : {8u, 36u + 10u}) set(changed, at, std::uint16_t{12});
  EXPECT_EQ(error_in(changed),
            "a.zip: a is compressed by method 12 of zip, which is not supported");
  for (const std::size_t at : {8u, 36u + 10u}) set(changed, at, std::uint16_t{8});
  EXPECT_THAT(error_in(changed), HasSubstr("a.zip: a is damaged (the deflate data is damaged"));
  changed = written(false, one);
  for (const std::size_t at : {22u, 36u + 24u}) set(changed, at, std::uint32_t{6});
  EXPECT_EQ(error_in(changed), "a.zip: a does not have the 6 bytes that the archive announces");
}

}  // namespace
}  // namespace qs::test
