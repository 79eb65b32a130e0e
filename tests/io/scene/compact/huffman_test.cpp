// SPDX-License-Identifier: MIT
#include "io/scene/compact/huffman.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/corpus.h"
#include "support/error_of.h"
#include "support/shared.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::ElementsAreArray;

constexpr std::uint64_t kAny = 1'000'000;

std::vector<std::byte> bytes_of(const std::vector<int>& values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

// 0, 10, 111, and 110 for the end.
const std::vector<HuffmanCode> kTable = {{0, 1, 1}, {37, 2, 1}, {255, 3, 1}, {kHuffmanEnd, 3, 0}};

std::vector<int> symbols_of(const std::vector<HuffmanCode>& table, const std::vector<int>& stream,
                            std::uint64_t most = kAny) {
  const auto symbols = HuffmanDecoder(table, "f").decode(bytes_of(stream), most);
  return {symbols.begin(), symbols.end()};
}

TEST(Huffman, streams_are_as_dahuffman_writes_them) {
  const std::vector<std::uint16_t> symbols = {0, 37, 255, 0};
  EXPECT_THAT(huffman_encode(kTable, symbols), ElementsAreArray(bytes_of({0xa6})));
  EXPECT_THAT(symbols_of(kTable, {0xa6}), ElementsAre(0, 37, 255, 0));
}

TEST(Huffman, a_stream_ends_with_its_bytes_or_with_the_end_symbol) {
  EXPECT_THAT(symbols_of(kTable, {0xff}), ElementsAre(0, 0, 0, 0, 0, 0, 0, 0));
  EXPECT_THAT(symbols_of(kTable, {0xfe}), ElementsAre(0, 0, 0, 0, 0, 0, 0));
  EXPECT_THAT(symbols_of(kTable, {0xf8}), ElementsAre(0, 0, 0, 0, 0));
  EXPECT_THAT(symbols_of(kTable, {0xff, 0x80}), ElementsAre(0, 0, 0, 0, 0, 0, 0, 0, 0));
  EXPECT_THAT(symbols_of(kTable, {}), ElementsAre());
}

TEST(Huffman, damaged_streams_are_refused) {
  const auto error = [](const std::vector<HuffmanCode>& table, const std::vector<int>& stream,
                        std::uint64_t most = kAny) {
    return error_of([&] { symbols_of(table, stream, most); });
  };
  EXPECT_EQ(error(kTable, {0xff}, 7), "f: has more than 7 symbols");
  EXPECT_EQ(error(kTable, {0xff}, 8), "");
  EXPECT_EQ(error(kTable, {0x80, 0xff}), "f: 1 bytes follow its 1 symbols");
  const std::vector<HuffmanCode> gap = {{1, 2, 3}, {kHuffmanEnd, 2, 2}};
  EXPECT_EQ(error(gap, {0xf0, 0}), "f: the bits behind its 2 symbols are not in its table");
  // A code of 20 bits that 16 bits do not finish.
  const std::vector<HuffmanCode> slow = {{1, 20, 0xfffff}, {kHuffmanEnd, 1, 0}};
  EXPECT_EQ(error(slow, {0xff, 0xff}), "f: the bits behind its 0 symbols are not in its table");
  EXPECT_THAT(symbols_of(slow, {0xff, 0xff, 0xf0}), ElementsAre(1));
}

TEST(Huffman, tables_that_are_no_prefix_codes_are_refused) {
  const auto error = [](const std::vector<HuffmanCode>& table) {
    return error_of([&] { HuffmanDecoder(table, "f"); });
  };
  const std::string sentence = "f: a code of its table is the beginning of another one";
  EXPECT_EQ(error({{1, 1, 0}, {2, 1, 0}}), sentence);
  EXPECT_EQ(error({{1, 1, 0}, {2, 2, 0}}), sentence);
  EXPECT_EQ(error({{2, 2, 0}, {1, 1, 0}}), sentence);
  EXPECT_EQ(error({{2, 2, 0}, {1, 1, 1}}), "");
}

TEST(Huffman, tables_are_read_from_pickles_and_damaged_ones_refused) {
  for (const char* name : {"table_2.huffman", "table_4.huffman"}) {
    const auto content = file_bytes(source_path("tests/data/tensors") / name);
    const Pickle pickle(content, "f");
    const auto table = read_huffman_table(pickle, pickle.root(), "f");
    const HuffmanDecoder decoder(table, "f");
    const auto symbols = decoder.decode(std::span(content).subspan(pickle.size()), kAny);
    ASSERT_EQ(symbols.size(), 150u);
    EXPECT_EQ(symbols[0], 0);
    EXPECT_EQ(symbols[1], 255);
    EXPECT_EQ(huffman_encode(table, std::vector(symbols.begin(), symbols.end())),
              std::vector(content.begin() + static_cast<long>(pickle.size()), content.end()));
  }
  const auto error = [](const std::string& items) {
    const auto content = to_bytes("}(" + items + "u.");
    const Pickle pickle(content, "f");
    return error_of([&] { read_huffman_table(pickle, pickle.root(), "g"); });
  };
  EXPECT_EQ(error(""), "g: its table is empty");
  EXPECT_EQ(error("K\1K\2K\3\x86"), "");
  EXPECT_EQ(error("K\1K\2K\4\x86"), "g: its table has the code 4 of 2 bits");
  EXPECT_EQ(error("K\1" + std::string("K\0", 2) + "K\1\x86"),
            "g: its table has the code 1 of 0 bits");
  EXPECT_EQ(error("K\1K\x40K\1\x86"), "g: its table has the code 1 of 64 bits");
  EXPECT_EQ(error("K\1K\2J\xff\xff\xff\xff\x86"), "g: its table has the code -1 of 2 bits");
  EXPECT_EQ(error("K\1K\2"), "f: its pickle: a code is an integer instead of a tuple");
  EXPECT_EQ(error("\x8c\1aK\2K\3\x86"),
            "g: a symbol of its table is no whole number from 0 to 65535");
  EXPECT_EQ(error("G\x7f\xf8" + std::string(6, '\0') + "K\2K\3\x86"),
            "g: a symbol of its table is no whole number from 0 to 65535");
  EXPECT_EQ(error("\x8a\3" + std::string("\0\0\1", 3) + "K\2K\3\x86"),
            "g: a symbol of its table is no whole number from 0 to 65535");
}

TEST(Huffman, made_tables_are_optimal_and_read_back) {
  std::mt19937 random(7);
  for (const std::size_t kinds : {1, 2, 3, 64, 256, 1000}) {
    for (const std::size_t count : {0, 1, 7, 10'000}) {
      std::vector<std::uint64_t> counts(kinds);
      std::vector<std::uint16_t> symbols(count);
      std::geometric_distribution<std::size_t> choose(0.05);
      for (std::uint16_t& symbol : symbols) {
        symbol = static_cast<std::uint16_t>(choose(random) % kinds);
        ++counts[symbol];
      }
      const auto table = make_huffman_table(counts);
      const auto stream = huffman_encode(table, symbols);
      const auto decoded = HuffmanDecoder(table, "f").decode(stream, kAny);
      EXPECT_EQ(std::vector(decoded.begin(), decoded.end()), symbols) << kinds << " " << count;
      double kraft = 0;
      for (const HuffmanCode& code : table) kraft += std::pow(0.5, code.bits);
      EXPECT_LE(kraft, 1);
      if (table.size() > 1) {
        EXPECT_EQ(kraft, 1);
      }
    }
  }
}

TEST(CodeBits, are_packed_as_numpy_packs_them) {
  const std::vector<std::uint16_t> numbers = {1, 2, 3, 40, 63, 0, 5, 6, 7, 8, 9, 10};
  const auto packed = pack_bits(numbers, 6);
  EXPECT_THAT(packed,
              ElementsAreArray(bytes_of({0x81, 0x0c, 0x05, 0xfc, 0x0a, 0x18, 0xe0, 0x49, 0x14})));
  EXPECT_THAT(unpack_bits(packed, numbers.size(), 6), ElementsAreArray(numbers));
  for (const int bits : {1, 5, 8, 13, 16}) {
    std::vector<std::uint16_t> some;
    for (unsigned i = 0; i < 100; ++i)
      some.push_back(static_cast<std::uint16_t>(i * 2654435761u >> 7 & ((1u << bits) - 1)));
    const auto bytes = pack_bits(some, bits);
    EXPECT_EQ(bytes.size(), packed_bytes(some.size(), bits));
    EXPECT_THAT(unpack_bits(bytes, some.size(), bits), ElementsAreArray(some));
  }
  EXPECT_TRUE(pack_bits({}, 6).empty());
}

}  // namespace
}  // namespace qs::test
