// SPDX-License-Identifier: MIT
//
// Files that PyTorch wrote, and pickles of tensors that were made by hand to do harm.
#include "io/tensor/torch_tensor.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/support/limits.h"
#include "io/support/zip_archive.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/shared.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(TorchFile, tensors_of_archives_and_streams_are_as_torch_saved_them) {
  for (const char* name : {"zip.pth", "stream.pth"}) {
    SCOPED_TRACE(name);
    const auto bytes = file_bytes(source_path("tests/data/tensors") / name);
    const TorchFile file(bytes, "f");
    const Tensor floats = file.tensor("floats");
    EXPECT_THAT(floats.shape, ElementsAre(2u, 3u));
    EXPECT_THAT(floats.values, ElementsAre(0, 0.25f, 0.5f, 0.75f, 1, 1.25f));
    EXPECT_THAT(file.tensor("halves").values,
                ElementsAre(1.5f, -2, INFINITY, testing::FloatNear(6e-8f, 1e-9f)));
    EXPECT_THAT(file.tensor("part").values, ElementsAre(3, 4, 5, 6));
    const Tensor parameter = file.tensor("parameter");
    EXPECT_THAT(parameter.shape, ElementsAre(1u, 1u));
    EXPECT_THAT(parameter.values, ElementsAre(7));
    EXPECT_THAT(file.tensor("empty").shape, ElementsAre(0u, 3u));
    EXPECT_TRUE(file.has("turned"));
    EXPECT_FALSE(file.has("missing"));
    EXPECT_EQ(error_of([&] { file.tensor("turned"); }), "f: turned is not stored in one piece");
    EXPECT_EQ(error_of([&] { file.tensor("missing"); }), "f: has no tensor missing");
  }
}

TEST(TorchFile, every_cut_is_refused_or_misses_values) {
  for (const char* name : {"zip.pth", "stream.pth"}) {
    const auto whole = file_bytes(source_path("tests/data/tensors") / name);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<long>(size));
      EXPECT_THAT(error_of([&] {
                    const TorchFile file(cut, "f");
                    for (const char* tensor : {"floats", "halves", "part", "parameter", "empty"})
                      file.tensor(tensor);
                  }),
                  testing::StartsWith("f: "))
          << name << " " << size;
    }
  }
}

TEST(TorchFile, every_changed_byte_gives_tensors_or_one_sentence) {
  const auto whole = file_bytes(source_path("tests/data/tensors/stream.pth"));
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int bits : {0x01, 0x80, 0xff}) {
      auto changed = whole;
      changed[at] ^= static_cast<std::byte>(bits);
      expect_within_limits([&] {
        const std::string error = error_of([&] {
          const TorchFile file(changed, "f");
          for (const char* tensor : {"floats", "halves", "part", "parameter", "empty"})
            if (file.has(tensor)) file.tensor(tensor);
        });
        EXPECT_TRUE(error.empty() || error.starts_with("f: ")) << error;
        EXPECT_EQ(error.find('\n'), std::string::npos);
        return std::size_t{0};
      });
    }
  }
}

// A pickle of one tensor "t" on a storage "s".
std::string pickled_tensor(const std::string& storage_size, const std::string& offset,
                           const std::string& shape, const std::string& strides) {
  return "}\x8c\1tctorch._utils\n_rebuild_tensor_v2\n(("
         "\x8c\7storagectorch\nFloatStorage\n\x8c\1s\x8c\3"
         "cpu" +
         storage_size + "tQ" + offset + shape + strides +
         "\x89"
         "ccollections\nOrderedDict\n)RtRs.";
}

std::string error_of_tensor(const std::string& pickle, std::size_t bytes) {
  const TemporaryFolder folder;
  write_zip(folder / "a.pth", {{"m/data.pkl", pickle}, {"m/data/s", std::string(bytes, '\0')}});
  const auto content = file_bytes(folder / "a.pth");
  std::string error;
  expect_within_limits([&] {
    error = error_of([&] { TorchFile(content, "f").tensor("t"); });
    return std::size_t{0};
  });
  return error;
}

TEST(TorchFile, hostile_tensors_are_refused_with_one_sentence) {
  const auto error = [&](const std::string& size, const std::string& offset,
                         const std::string& shape, const std::string& strides,
                         std::size_t bytes = 16) {
    return error_of_tensor(pickled_tensor(size, offset, shape, strides), bytes);
  };
  const std::string four = "K\4", zero("K\0", 2), one = "K\1";
  const std::string large("\x8a\7\0\0\0\0\0\0\1", 9);  // 2^48
  const std::string negative("J\xff\xff\xff\xff", 5);
  EXPECT_EQ(error(four, zero, "K\4\x85", "K\1\x85"), "");
  EXPECT_EQ(error(four, zero, "K\5\x85", "K\1\x85"), "f: t has more values than its storage of 4");
  EXPECT_EQ(error(four, one, "K\4\x85", "K\1\x85"),
            "f: t has 4 values from 1 on, but its storage has 4");
  EXPECT_EQ(error(four, large, "K\4\x85", "K\1\x85"),
            "f: t has 4 values from 281474976710656 on, but its storage has 4");
  EXPECT_EQ(error(four, negative, "K\4\x85", "K\1\x85"),
            "f: t has 4 values from -1 on, but its storage has 4");
  EXPECT_EQ(error(four, zero, large + large + "\x86", large + "K\1\x86"),
            "f: t has more values than its storage of 4");
  EXPECT_EQ(error(four, zero, negative + "\x85", "K\1\x85"), "f: t has a side of -1");
  EXPECT_EQ(error(four, zero, "K\4\x85", zero + "\x85"), "f: t is not stored in one piece");
  EXPECT_EQ(error(four, zero, "K\4\x85", "K\1K\1\x86"),
            "f: its pickle: a tensor's strides has 2 items instead of 1");
  EXPECT_EQ(error(four, zero, "K\4\x85", "K\1\x85", 12),
            "f: cut off: storage s has 12 bytes instead of 16");
  EXPECT_EQ(error(four, zero, "K\4\x85", "K\1\x85", 20),
            "f: m/data/s has 20 bytes unpacked, more than the 16 that make sense");
  EXPECT_EQ(error(negative, zero, "K\4\x85", "K\1\x85"), "f: its pickle: a storage has -1 values");
  EXPECT_EQ(error(large, zero, "K\4\x85", "K\1\x85"),
            "f: its pickle: a storage has 281474976710656 values");
  EXPECT_EQ(error("N", zero, "K\4\x85", "K\1\x85"),
            "f: its pickle: the size of a storage is None instead of an integer");
}

TEST(TorchFile, other_files_are_refused) {
  const auto error = [](const std::string& text) {
    const auto bytes = to_bytes(text);
    return error_of([&] { TorchFile(bytes, "f"); });
  };
  EXPECT_THAT(error("hello"), HasSubstr("f: its pickle: "));
  EXPECT_EQ(error("K\1."), "f: not a file of PyTorch");
  const TemporaryFolder folder;
  write_zip(folder / "a.pth", {{"m/data.pkl", "]."}});
  const auto list = file_bytes(folder / "a.pth");
  EXPECT_EQ(error_of([&] { TorchFile(list, "f"); }), "f: holds no dictionary of tensors");
  write_zip(folder / "b.pth", {{"m/code.py", "]."}});
  const auto other = file_bytes(folder / "b.pth");
  EXPECT_EQ(error_of([&] { TorchFile(other, "f"); }), "f: a zip archive without data.pkl");
}

}  // namespace
}  // namespace qs::test
