// SPDX-License-Identifier: MIT
//
// The building blocks of the readers at the limits of accepted input.
#include <cstdint>
#include <limits>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "io/bytes/base64.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/file_source.h"
#include "io/bytes/inflate.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "support/corpus.h"
#include "support/gzip.h"

namespace qs::test {
namespace {

using testing::HasSubstr;

TEST(Base64, has_the_examples_of_its_standard) {
  const char* const pairs[][2] = {{"", ""},
                                  {"f", "Zg=="},
                                  {"fo", "Zm8="},
                                  {"foo", "Zm9v"},
                                  {"foob", "Zm9vYg=="},
                                  {"fooba", "Zm9vYmE="},
                                  {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : pairs) EXPECT_EQ(base64(bytes), text);
  EXPECT_EQ(base64("\xff\xef\xbe"), "/+++");
}

TEST(Base64, any_bytes_survive_a_data_uri) {
  std::mt19937 random(5);
  for (std::size_t size = 0; size < 70; ++size) {
    std::string bytes(size, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    const auto decoded =
        decode_data_uri("data:application/octet-stream;base64," + base64(bytes), "");
    const auto expected = to_bytes(bytes);
    EXPECT_TRUE(std::equal(decoded.begin(), decoded.end(), expected.begin(), expected.end()));
  }
}

TEST(ByteCursor, reads_to_the_last_byte_and_not_beyond) {
  const auto bytes = to_bytes(std::string("\x01\x02\x03\x04\x05\x06", 6));
  ByteCursor cursor(bytes, "file");
  EXPECT_EQ(cursor.read<std::uint16_t>("a"), 0x0201);
  EXPECT_EQ(cursor.left(), 4u);
  EXPECT_THROW(cursor.read<std::uint64_t>("b"), Error);
  EXPECT_EQ(cursor.read<std::uint32_t>("c"), 0x06050403u);
  EXPECT_EQ(cursor.offset(), 6u);
  EXPECT_EQ(cursor.take(0, "nothing").size(), 0u);
  EXPECT_THROW(cursor.read<std::uint8_t>("d"), Error);
}

TEST(ByteCursor, fits_does_not_overflow) {
  EXPECT_TRUE(fits(3, 4, 12));
  EXPECT_TRUE(fits(3, 4, 15));
  EXPECT_FALSE(fits(3, 4, 11));
  EXPECT_TRUE(fits(~std::uint64_t{0}, 0, 0));
  EXPECT_FALSE(fits((std::uint64_t{1} << 61) + 1, 8, 8));
}

TEST(Inflater, fills_buffers_of_any_size_and_verifies_the_checksum) {
  const std::string plain = "some text, some text, some text";
  auto packed = to_bytes(gzip(plain, 9));
  for (const std::size_t size : {1u, 5u, 31u, 100u}) {
    Inflater inflater(packed, "file");
    std::string read;
    std::vector<std::byte> buffer(size);
    std::size_t got = 0;
    do {
      got = inflater.read(buffer);
      read.append(reinterpret_cast<const char*>(buffer.data()), got);
    } while (got == size);
    EXPECT_EQ(read, plain);
    EXPECT_EQ(inflater.left(), 0u);
  }
  std::vector<std::byte> buffer(100);
  packed[packed.size() - 5] ^= std::byte{1};  // of the checksum
  EXPECT_THROW(Inflater(packed, "file").read(buffer), Error);
}

TEST(Json, nesting_and_values_are_limited) {
  const auto nested = [](int depth) {
    return std::string(static_cast<std::size_t>(depth), '[') +
           std::string(static_cast<std::size_t>(depth), ']');
  };
  EXPECT_NO_THROW(parse_json(nested(64), "file"));
  EXPECT_THROW(parse_json(nested(65), "file"), Error);
  EXPECT_NO_THROW(parse_json(R"(["[[,\",", 2, 3])", "file", 3));
  EXPECT_THROW(parse_json("[1, 2, 3]", "file", 2), Error);
}

TEST(Json, numbers_are_checked_at_their_borders) {
  const auto check = [](const char* text, auto read) {
    const auto object = parse_json(text, "file");
    const std::string where = "file";
    return read(JsonEntry{object, where});
  };
  const auto side = [](const JsonEntry& entry) { return entry.side("w"); };
  EXPECT_EQ(check(R"({"w": 1})", side), 1);
  EXPECT_EQ(check(R"({"w": 65535})", side), 65535);
  for (const char* wrong : {R"({"w": 0})", R"({"w": 65536})", R"({"w": 1.5})", R"({"w": "1"})",
                            R"({"w": null})", R"({})"}) {
    EXPECT_THROW(check(wrong, side), Error) << wrong;
  }
  const auto positive = [](const JsonEntry& entry) { return entry.positive("f"); };
  EXPECT_EQ(check(R"({"f": 1e-9})", positive), 1e-9);
  EXPECT_THROW(check(R"({"f": 0})", positive), Error);
  const auto vector = [](const JsonEntry& entry) { return entry.vector<3>(entry.get("v"), "v"); };
  EXPECT_EQ(check(R"({"v": [1, 2, 3]})", vector), glm::dvec3(1, 2, 3));
  EXPECT_THROW(check(R"({"v": [1, 2]})", vector), Error);
  EXPECT_THROW(check(R"({"v": [1, 2, 3, 4]})", vector), Error);
}

TEST(Json, a_whole_number_is_read_only_into_a_type_that_holds_it) {
  const auto accepted = []<class T>(const char* text, T expected) {
    EXPECT_EQ(json_value<T>(parse_own_json(text)), expected) << text;
  };
  accepted("-2147483648", std::numeric_limits<int>::min());
  accepted("2147483647", std::numeric_limits<int>::max());
  accepted("18446744073709551615", std::numeric_limits<std::uint64_t>::max());
  accepted("0", std::uint64_t{0});
  accepted("1e30", 1e30);
  accepted("true", true);
  const auto rejected = []<class T>(const char* text, T) {
    EXPECT_THROW(json_value<T>(parse_own_json(text)), nlohmann::json::exception) << text;
  };
  for (const char* text : {"-2147483649", "2147483648", "18446744073709551615", "7e51", "1.0",
                           "true", "null", "\"1\""})
    rejected(text, 0);
  for (const char* text : {"-1", "1.5", "1e30", "null"}) rejected(text, std::uint64_t{0});
}

TEST(FileSource, only_plain_relative_names_are_safe) {
  EXPECT_EQ(checked_file_name("a/./b.webp", "file"), "a/b.webp");
  EXPECT_EQ(checked_file_name("..a", "file"), "..a");
  for (const char* name :
       {"", "/etc/passwd", "../a", "a/../../b", "a/", "http://x/y", "c:\\a", "a\nb", ".."}) {
    EXPECT_THROW(checked_file_name(name, "file"), Error) << name;
  }
}

}  // namespace
}  // namespace qs::test
