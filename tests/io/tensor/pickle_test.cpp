// SPDX-License-Identifier: MIT
//
// Pickles of Python, and pickles that were made by hand to do harm.
#include "io/tensor/pickle.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/support/limits.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/shared.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::StartsWith;

std::string error_of_pickle(const std::string& text) {
  const auto bytes = to_bytes(text);
  return error_of([&] { Pickle(bytes, "f"); }, ErrorKind::input);
}

TEST(Pickle, objects_of_all_protocols_are_as_python_saved_them) {
  for (const int protocol : {3, 4, 5}) {
    SCOPED_TRACE(protocol);
    const auto bytes =
        file_bytes(source_path("tests/data/tensors/protocol_" + std::to_string(protocol) + ".pkl"));
    const Pickle pickle(bytes, "f");
    EXPECT_EQ(pickle.size(), bytes.size());
    const auto value = [&](const char* key) { return pickle.find(pickle.root(), key); };
    EXPECT_EQ(pickle.text(value("text"), ""), "b\u00e4r");
    EXPECT_THAT(pickle[value("bytes")].bytes, ElementsAre(std::byte{0}, std::byte{0xff}));
    const PickleObject& numbers = pickle[value("numbers")];
    ASSERT_EQ(numbers.kind, PickleKind::list);
    ASSERT_EQ(numbers.items.size(), 6u);
    const std::vector<std::int64_t> expected = {0, 255, 65535, -1, std::int64_t{1} << 40};
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_EQ(pickle.integer(numbers.items[i], ""), expected[i]);
    const PickleObject& large = pickle[numbers.items[5]];  // -2^70
    EXPECT_EQ(large.kind, PickleKind::long_integer);
    EXPECT_THAT(large.bytes, testing::SizeIs(9));
    EXPECT_EQ(large.bytes.back(), std::byte{0xc0});
    const auto reals = pickle.tuple(value("reals"), 2, "");
    EXPECT_EQ(pickle[reals[0]].real, 0.5);
    EXPECT_EQ(pickle[reals[1]].real, -1e300);
    const PickleObject& flags = pickle[value("flags")];
    ASSERT_EQ(flags.items.size(), 3u);
    EXPECT_EQ(pickle[flags.items[0]].integer, 1);
    EXPECT_EQ(pickle[flags.items[1]].integer, 0);
    EXPECT_EQ(pickle[flags.items[2]].kind, PickleKind::none);
    const PickleRef list = pickle.find(value("nested"), "list");
    EXPECT_EQ(pickle[list].items.size(), 3u);
    EXPECT_EQ(value("again"), value("numbers"));  // the same object
    EXPECT_EQ(value("missing"), 0u);
    EXPECT_EQ(pickle.find(list, "list"), 0u);
  }
}

TEST(Pickle, names_that_no_model_needs_are_refused_by_name) {
  const std::string refused = " is not needed by any model and was refused";
  EXPECT_EQ(error_of_pickle("\x80\x02"
                            "cos\nsystem\n)R."),
            "f: its pickle: the name os.system" + refused);
  EXPECT_EQ(error_of_pickle("\x80\x04\x8c\x08"
                            "builtins\x8c\x04"
                            "eval\x93."),
            "f: its pickle: the name builtins.eval" + refused);
  // No part of a known name is known.
  EXPECT_EQ(error_of_pickle("ctorch\n_utils\n."), "f: its pickle: the name torch._utils" + refused);
  EXPECT_EQ(error_of_pickle("ctorch.FloatStorage\n\n."),
            "f: its pickle: the name torch.FloatStorage." + refused);
  EXPECT_EQ(error_of_pickle("c\x1b[2J\nsystem\n."),
            "f: its pickle: the name ?[2J.system" + refused);
  EXPECT_EQ(error_of_pickle("c" + std::string(100, 'm') + "\nf\n."),
            "f: its pickle: the name " + std::string(60, 'm') + "....f" + refused);
  EXPECT_EQ(error_of_pickle("cos"), "f: its pickle: a name is cut off");
}

TEST(Pickle, known_names_are_called_only_as_they_may_be) {
  EXPECT_EQ(error_of_pickle("ctorch\nFloatStorage\n)R."),
            "f: its pickle: torch.FloatStorage is called, but must only be mentioned");
  EXPECT_EQ(error_of_pickle("cdahuffman.huffmancodec\n_EndOfFileSymbol\n)R."),
            "f: its pickle: dahuffman.huffmancodec._EndOfFileSymbol is called, but must only be "
            "mentioned");
  EXPECT_EQ(error_of_pickle("cdahuffman.huffmancodec\n_EndOfFileSymbol\n)\x81."), "");
  EXPECT_EQ(error_of_pickle("\x8c\x02os)R."), "f: its pickle: a text is called");
  EXPECT_EQ(error_of_pickle("ccollections\nOrderedDict\nK\x01\x85R."),
            "f: its pickle: collections.OrderedDict has arguments");
  EXPECT_EQ(error_of_pickle("ccollections\nOrderedDict\n]R."),
            "f: its pickle: the arguments of collections.OrderedDict are not a tuple");
  EXPECT_EQ(error_of_pickle("ccollections\nOrderedDict\n)R}b."), "");
  EXPECT_EQ(error_of_pickle("]}b."), "f: its pickle: a list is given a state");
}

TEST(Pickle, operations_that_no_model_needs_are_refused_by_name) {
  const std::string refused = " is not needed by any model and was refused";
  const std::pair<char, const char*> operations[] = {
      {'i', "INST"},    {'o', "OBJ"},      {'P', "PERSID"},       {'2', "DUP"},
      {'0', "POP"},     {'1', "POP_MARK"}, {'I', "INT"},          {'\x82', "EXT1"},
      {'\x83', "EXT2"}, {'\x84', "EXT4"},  {'\x92', "NEWOBJ_EX"}, {'\x97', "NEXT_BUFFER"}};
  for (const auto& [code, name] : operations) {
    EXPECT_EQ(error_of_pickle(std::string("]") + code + "."),
              std::string("f: its pickle: the operation ") + name + refused);
  }
  EXPECT_EQ(error_of_pickle("\xff."), "f: its pickle: the operation 0xff is unknown");
  EXPECT_EQ(error_of_pickle("\x80\x06N."),
            "f: its pickle: protocol 6 is unknown, 5 is the newest known");
}

TEST(Pickle, operations_without_operands_are_refused) {
  const std::string lacks = "f: its pickle: an operation lacks its operands";
  for (const char* text :
       {".", "a.", "]a.", "K\x01\x85\x86.", "R.", "b.", "Q.", "(s.", "q", "q\x01."})
    EXPECT_THAT(error_of_pickle(text), testing::AnyOf(lacks, StartsWith("f: its pickle: cut off")))
        << text;
  EXPECT_EQ(error_of_pickle("t."), "f: its pickle: an operation lacks its mark");
  EXPECT_EQ(error_of_pickle("]h\x07."), "f: its pickle: object 7 was not remembered");
  EXPECT_EQ(error_of_pickle("]]."), "f: its pickle: objects are left over at its end");
  EXPECT_EQ(error_of_pickle("](."), "f: its pickle: an operation lacks its operands");
  EXPECT_EQ(error_of_pickle("]K\x01K\x02s."),
            "f: its pickle: items are added to a list instead of a dictionary");
  EXPECT_EQ(error_of_pickle("}(K\x01u."), "f: its pickle: a key has no value");
  EXPECT_EQ(error_of_pickle("]"),
            "f: its pickle: cut off: an operation needs 1 bytes at offset 1, "
            "0 are left");
  EXPECT_EQ(error_of_pickle(""),
            "f: its pickle: cut off: an operation needs 1 bytes at offset 0, "
            "0 are left");
}

TEST(Pickle, lists_may_hold_themselves) {
  const auto bytes = to_bytes("]q\1h\1a.");
  const Pickle pickle(bytes, "f");
  ASSERT_EQ(pickle[pickle.root()].items.size(), 1u);
  EXPECT_EQ(pickle[pickle.root()].items[0], pickle.root());
}

TEST(Pickle, bombs_are_refused_within_the_limits) {
  const auto expect = [](const std::string& text, const std::string& sentence) {
    expect_within_limits([&] {
      EXPECT_EQ(error_of_pickle(text), sentence);
      return std::size_t{0};
    });
  };
  expect(std::string(100'000, '('), "f: its pickle: more than 256 objects are nested");
  expect(std::string(2'000'000, ']'), "f: its pickle: it has more than 1048576 operations");
  // Each pair holds the previous pair twice: 2^60 lists if they were copied.
  std::string doubled = "]q\1";
  for (int i = 0; i < 60; ++i) doubled += "h\1\x86q\1";
  expect(doubled + ".", "");
  // A tuple of 60,000 items becomes the arguments of 50 calls.
  std::string calls = "(";
  for (int i = 0; i < 60'000; ++i) calls += "N";
  calls += "tq\1";
  for (int i = 0; i < 50; ++i) calls += "cnumpy\ndtype\nh\1R";
  expect(calls, "f: its pickle: its objects have more than 2097152 items");
  std::string memo;
  for (int i = 0; i < 300'000; ++i) memo += i == 0 ? "]\x94" : "\x94";
  expect(memo, "f: its pickle: more than 262144 objects are remembered");
  expect("\x8a\xff" + std::string(255, '\1') + ".", "f: its pickle: an integer of 255 bytes");
  expect("B\xff\xff\xff\xff",
         "f: its pickle: cut off: bytes needs 4294967295 bytes at offset 5, 0 "
         "are left");
  expect(std::string("\x8e\xff\xff\xff\xff\xff\xff\xff\xff", 9),
         "f: its pickle: cut off: bytes needs 18446744073709551615 bytes at offset 9, 0 are left");
  expect("\x95" + std::string(8, '\xff'), "f: its pickle: a frame is cut off");
}

TEST(Pickle, damaged_files_are_refused_or_read) {
  const auto whole = file_bytes(source_path("tests/data/tensors/protocol_4.pkl"));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<long>(size));
    EXPECT_THAT(error_of([&] { Pickle(cut, "f"); }), StartsWith("f: its pickle: ")) << size;
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (int value = 0; value < 256; ++value) {
      auto changed = whole;
      changed[at] = static_cast<std::byte>(value);
      const std::string error = error_of([&] { Pickle(changed, "f"); }, ErrorKind::input);
      EXPECT_TRUE(error.empty() || error.starts_with("f: its pickle: ")) << error;
    }
  }
}

TEST(Pickle, accessors_say_what_is_wrong) {
  const std::string text("K\1X\1\0\0\0a\x86.", 10);
  const auto content = to_bytes(text);
  const Pickle pickle(content, "f");
  const auto items = pickle.tuple(pickle.root(), 2, "the pair");
  EXPECT_EQ(error_of([&] { pickle.text(items[0], "a name"); }),
            "f: its pickle: a name is an integer instead of a text");
  EXPECT_EQ(error_of([&] { pickle.integer(items[1], "a size"); }),
            "f: its pickle: a size is a text instead of an integer");
  EXPECT_EQ(error_of([&] { pickle.tuple(pickle.root(), 3, "the pair"); }),
            "f: its pickle: the pair has 2 items instead of 3");
  EXPECT_EQ(error_of([&] { pickle.tuple(items[0], "the pair"); }),
            "f: its pickle: the pair is an integer instead of a tuple");
  EXPECT_EQ(error_of([&] { pickle.call(items[0], "numpy.dtype", 0, "a type"); }),
            "f: its pickle: a type is an integer instead of a result of numpy.dtype");
}

}  // namespace
}  // namespace qs::test
