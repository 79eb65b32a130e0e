// SPDX-License-Identifier: MIT
#include <cstring>
#include <optional>
#include <string_view>

#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/json_text.h"
#include "io/bytes/mapped_file.h"
#include "io/tensor/tensor.h"

namespace qs {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxHeaderValues = 1 << 20;
constexpr std::string_view kMetadata = "__metadata__";

// A name of the file for a message: quoted, in one line, not longer than a line.
std::string quoted(const std::string& name) {
  constexpr std::size_t kLongest = 60;
  return json_line(name.size() > kLongest ? name.substr(0, kLongest) + "..." : name);
}

// Whole numbers from 0 on; nothing if the value is no list of them.
std::optional<std::vector<std::uint64_t>> whole_numbers(const json& tensor, const char* key) {
  const auto list = tensor.find(key);
  if (list == tensor.end() || !list->is_array()) return std::nullopt;
  std::vector<std::uint64_t> numbers;
  for (const json& number : *list) {
    if (!number.is_number_unsigned()) return std::nullopt;
    numbers.push_back(number.get<std::uint64_t>());
  }
  return numbers;
}

Tensor read_tensor(const json& entry, ByteSpan data, const std::string& where) {
  if (!entry.is_object()) fail("{}: is not an object", where);
  const auto type = entry.find("dtype");
  if (type == entry.end() || !type->is_string()) fail("{}: dtype is missing", where);
  if (*type != "F32")
    fail("{}: has the type {}, but only F32 is read", where, quoted(type->get<std::string>()));
  const auto shape = whole_numbers(entry, "shape");
  if (!shape) fail("{}: shape is not a list of whole numbers", where);
  const auto offsets = whole_numbers(entry, "data_offsets");
  if (!offsets || offsets->size() != 2) fail("{}: data_offsets are not two whole numbers", where);
  const std::uint64_t begin = (*offsets)[0], end = (*offsets)[1];
  if (begin > end || end > data.size())
    fail("{}: bytes {} to {} are not in the {} bytes of values", where, begin, end, data.size());
  const std::uint64_t bytes = end - begin;
  std::uint64_t count = 1;
  for (const std::uint64_t side : *shape) {
    if (!fits(count, side, bytes / sizeof(float)))
      fail("{}: its shape does not fit into {} bytes", where, bytes);
    count *= side;
  }
  if (count * sizeof(float) != bytes)
    fail("{}: its shape needs {} bytes, but it has {}", where, count * sizeof(float), bytes);
  Tensor tensor{*shape, std::vector<float>(count)};
  if (count > 0) std::memcpy(tensor.values.data(), data.data() + begin, bytes);
  return tensor;
}

}  // namespace

TensorFile parse_safetensors(ByteSpan content, const std::string& source) {
  ByteCursor cursor(content, source);
  const auto header_bytes = cursor.read<std::uint64_t>("the length of the header");
  const auto header = cursor.take(header_bytes, "the header");
  const auto data = content.subspan(cursor.offset());
  const json root = parse_json(text_of(header), source, kMaxHeaderValues);
  if (!root.is_object()) fail("{}: the header is not an object", source);
  TensorFile file;
  std::uint64_t values_left = data.size() / sizeof(float);
  for (const auto& [name, entry] : root.items()) {
    if (name == kMetadata) {
      if (!entry.is_object()) fail("{}: {} is not an object", source, kMetadata);
      for (const auto& [key, value] : entry.items()) {
        if (!value.is_string()) fail("{}: {}: {} is not a text", source, kMetadata, quoted(key));
        file.metadata[key] = value.get<std::string>();
      }
      continue;
    }
    const std::string where = fmt::format("{}: {}", source, quoted(name));
    Tensor tensor = read_tensor(entry, data, where);
    // Otherwise a small file could name its values many times and fill the memory.
    if (tensor.values.size() > values_left) fail("{}: shares values with other tensors", where);
    values_left -= tensor.values.size();
    file.tensors[name] = std::move(tensor);
  }
  return file;
}

TensorFile read_safetensors(const std::filesystem::path& path) {
  const MappedFile file(path);
  return parse_safetensors(file.content(), path.string());
}

}  // namespace qs
