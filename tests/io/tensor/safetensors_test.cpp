// SPDX-License-Identifier: MIT
#include "support/safetensors.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/tensor/tensor.h"
#include "support/error_of.h"
#include "support/shared.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::ElementsAre;

std::vector<std::byte> floats(const std::vector<float>& values) {
  std::vector<std::byte> bytes(values.size() * sizeof(float));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

TEST(Safetensors, tensors_have_their_shapes_and_values) {
  const TensorFile file = read_safetensors(test::source_path("tests/data/tensors/two.safetensors"));
  EXPECT_THAT(file.metadata, ElementsAre(testing::Pair("network", "small")));
  ASSERT_EQ(file.tensors.size(), 3u);
  EXPECT_THAT(file.tensors.at("a.weight").shape, ElementsAre(2u, 3u));
  EXPECT_THAT(file.tensors.at("a.weight").values, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(file.tensors.at("a.bias").shape, ElementsAre());
  EXPECT_THAT(file.tensors.at("a.bias").values, ElementsAre(-0.5f));
  EXPECT_THAT(file.tensors.at("empty").shape, ElementsAre(0u, 5u));
  EXPECT_TRUE(file.tensors.at("empty").values.empty());
}

TEST(Safetensors, a_file_without_tensors_is_empty) {
  const TensorFile file = parse_safetensors(test::safetensors_bytes("{}", {}), "f");
  EXPECT_TRUE(file.tensors.empty());
  EXPECT_TRUE(file.metadata.empty());
}

TEST(Safetensors, damaged_files_are_refused_with_one_sentence) {
  const auto expect = [](const std::string& header, const std::string& sentence) {
    const auto bytes = test::safetensors_bytes(header, floats({1, 2, 3, 4}));
    EXPECT_EQ(test::error_of([&] { parse_safetensors(bytes, "f"); }), "f: " + sentence) << header;
  };
  const auto expect_tensor = [&](const std::string& entry, const std::string& sentence) {
    expect("{\"a\":" + entry + "}", "\"a\": " + sentence);
  };
  expect("[1]", "the header is not an object");
  expect("{\"__metadata__\":3}", "__metadata__ is not an object");
  expect("{\"__metadata__\":{\"network\":3}}", "__metadata__: \"network\" is not a text");
  expect_tensor("7", "is not an object");
  expect_tensor("{}", "dtype is missing");
  expect_tensor(R"({"dtype":"BF16"})", "has the type \"BF16\", but only F32 is read");
  expect_tensor(R"({"dtype":"F32"})", "shape is not a list of whole numbers");
  expect_tensor(R"({"dtype":"F32","shape":[2.5]})", "shape is not a list of whole numbers");
  expect_tensor(R"({"dtype":"F32","shape":[-2]})", "shape is not a list of whole numbers");
  expect_tensor(R"({"dtype":"F32","shape":[2],"data_offsets":[0]})",
                "data_offsets are not two whole numbers");
  expect_tensor(R"({"dtype":"F32","shape":[2],"data_offsets":[8,0]})",
                "bytes 8 to 0 are not in the 16 bytes of values");
  expect_tensor(R"({"dtype":"F32","shape":[2],"data_offsets":[0,17]})",
                "bytes 0 to 17 are not in the 16 bytes of values");
  expect_tensor(R"({"dtype":"F32","shape":[2],"data_offsets":[0,18446744073709551615]})",
                "bytes 0 to 18446744073709551615 are not in the 16 bytes of values");
  expect_tensor(R"({"dtype":"F32","shape":[1],"data_offsets":[0,8]})",
                "its shape needs 4 bytes, but it has 8");
  expect_tensor(R"({"dtype":"F32","shape":[1],"data_offsets":[0,6]})",
                "its shape needs 4 bytes, but it has 6");
  expect_tensor(R"({"dtype":"F32","shape":[4294967296,4294967296],"data_offsets":[0,8]})",
                "its shape does not fit into 8 bytes");
  expect(R"({"a":{"dtype":"F32","shape":[3],"data_offsets":[0,12]},)"
         R"("b":{"dtype":"F32","shape":[3],"data_offsets":[4,16]}})",
         "\"b\": shares values with other tensors");
  expect("{\"" + std::string(1000, 'x') + "\\n\":7}",
         "\"" + std::string(60, 'x') + "...\": is not an object");
  EXPECT_EQ(test::error_of([] { parse_safetensors({}, "f"); }),
            "f: cut off: the length of the header needs 8 bytes at offset 0, 0 are left");
  auto long_header = test::safetensors_bytes("{}", {});
  long_header[7] = std::byte{0xff};
  EXPECT_THAT(test::error_of([&] { parse_safetensors(long_header, "f"); }),
              testing::StartsWith("f: cut off: the header needs "));
  EXPECT_THAT(test::error_of([&] { parse_safetensors(test::safetensors_bytes("{", {}), "f"); }),
              testing::StartsWith("f: not valid JSON"));
}

TEST(Safetensors, every_cut_of_a_file_is_refused) {
  const auto bytes = test::file_bytes(test::source_path("tests/data/tensors/two.safetensors"));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::vector<std::byte> cut(bytes.begin(),
                                     bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_THAT(test::error_of([&] { parse_safetensors(cut, "f"); }), testing::StartsWith("f: "))
        << size;
  }
}

}  // namespace
}  // namespace qs
