// SPDX-License-Identifier: MIT
#include "io/tensor/npy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/corpus.h"
#include "support/error_of.h"

namespace qs::test {
namespace {

using testing::ElementsAre;

std::vector<std::byte> npy(const std::string& type, const std::string& shape, std::size_t bytes) {
  return to_bytes(npy_header(type, shape) + std::string(bytes, '\1'));
}

TEST(Npy, arrays_have_their_type_shape_and_values) {
  const auto read = [](const std::string& type, const std::string& shape, std::size_t bytes) {
    const auto content = npy(type, shape, bytes);
    const NpyArray array = parse_npy(content, "f");
    EXPECT_EQ(array.type, type);
    EXPECT_EQ(array.values.size(), bytes);
    return array.shape;
  };
  EXPECT_THAT(read("<f2", "(2, 3)", 12), ElementsAre(2u, 3u));
  EXPECT_THAT(read("<f4", "(5,)", 20), ElementsAre(5u));
  EXPECT_THAT(read("|u1", "(7,)", 7), ElementsAre(7u));
  EXPECT_THAT(read("<i8", "(2,)", 16), ElementsAre(2u));
  EXPECT_THAT(read("|O", "()", 99), ElementsAre());
  EXPECT_THAT(read("<f8", "(0, 3)", 0), ElementsAre(0u, 3u));
}

TEST(Npy, arrays_that_do_not_fit_are_refused) {
  const auto error = [](const std::string& type, const std::string& shape, std::size_t bytes) {
    const auto content = npy(type, shape, bytes);
    return error_of([&] { parse_npy(content, "f"); });
  };
  EXPECT_EQ(error("<f2", "(2, 3)", 11), "f: its shape does not fit its 11 bytes of values");
  EXPECT_EQ(error("<f2", "(2, 3)", 14), "f: its shape does not fit its 14 bytes of values");
  EXPECT_EQ(error("<f4", "(4294967296, 4294967296, 2)", 8),
            "f: its shape does not fit its 8 bytes of values");
  EXPECT_EQ(error("<f4", "(9223372036854775807, 4)", 16),
            "f: its shape does not fit its 16 bytes of values");
  EXPECT_EQ(error("<f4", "(-1,)", 4), "f: a side of its shape is -1");
  EXPECT_EQ(error("<f4", "(x,)", 4), "f: its shape is not a tuple of whole numbers");
  EXPECT_EQ(error("<f4", "[1]", 4), "f: its shape is not a tuple of whole numbers");
  for (const char* type : {">f4", "<f3", "<U5", "|S1", "<c8", "", "|f4"})
    EXPECT_EQ(error(type, "(1,)", 4), "f: its values have a type that is not read") << type;
  const auto whole = npy("<f4", "(1,)", 4);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<long>(size));
    EXPECT_THAT(error_of([&] { parse_npy(cut, "f"); }), testing::StartsWith("f: ")) << size;
  }
}

}  // namespace
}  // namespace qs::test
