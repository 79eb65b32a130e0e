// SPDX-License-Identifier: MIT
#include "io/scene/gltf/gltf_file.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/bytes/base64.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/file_source.h"
#include "io/bytes/json_text.h"

namespace qs {
namespace {

using json = nlohmann::json;

constexpr std::size_t kMaxValues = 1 << 20;
constexpr std::uint64_t kMaxBufferBytes = std::uint64_t{1} << 36;

// The two chunks of a .glb.
struct Chunks {
  std::string_view description;
  std::span<const std::byte> binary;
};

Chunks open_glb(std::span<const std::byte> content, const std::string& path) {
  constexpr std::uint32_t kJson = 0x4E4F534A, kBinary = 0x004E4942;
  ByteCursor whole(content, path);
  whole.read<std::uint32_t>("the header");  // magic
  const auto version = whole.read<std::uint32_t>("the header");
  if (version != 2) fail("{}: binary glTF version {}, only 2 can be read", path, version);
  const auto length = whole.read<std::uint32_t>("the header");
  constexpr std::uint32_t kHeaderBytes = 12;
  if (length < kHeaderBytes) fail("{}: the header announces {} bytes", path, length);
  ByteCursor cursor(whole.take(length - kHeaderBytes, "the whole file"), path);
  if (whole.left() > 0)
    fail("{}: the header announces {} bytes, the file has {}", path, length, content.size());

  const auto description_bytes = cursor.read<std::uint32_t>("the first chunk");
  if (cursor.read<std::uint32_t>("the first chunk") != kJson) {
    fail("{}: the first chunk is not JSON", path);
  }
  Chunks chunks;
  chunks.description = text_of(cursor.take(description_bytes, "the JSON chunk"));
  while (cursor.left() >= 8) {
    const auto bytes = cursor.read<std::uint32_t>("a chunk");
    const auto type = cursor.read<std::uint32_t>("a chunk");
    const auto chunk = cursor.take(bytes, "a chunk");
    if (type == kBinary && chunks.binary.empty()) chunks.binary = chunk;
  }
  if (cursor.left() > 0) fail("{}: {} bytes follow the last chunk", path, cursor.left());
  return chunks;
}

// tinygltf treats a stride of 0 as no stride, and numbers below 0 as absent; the specification
// forbids both.
void check_layout(const json& root, const std::string& path) {
  for (const char* list : {"bufferViews", "accessors"}) {
    const auto entries = root.find(list);
    if (entries == root.end() || !entries->is_array()) continue;
    for (std::size_t i = 0; i < entries->size(); ++i) {
      const json& entry = (*entries)[i];
      if (!entry.is_object()) continue;
      for (const char* key : {"byteOffset", "byteLength", "byteStride", "count"}) {
        const auto value = entry.find(key);
        if (value == entry.end()) continue;
        if (!value->is_number() || *value < 0)
          fail("{}: {}[{}]: {} is not a number from 0 on", path, list, i, key);
        if (*value == 0 && std::string_view(key) == "byteStride")
          fail("{}: a bufferView has a byteStride of 0", path);
      }
    }
  }
}

template <class T>
float number(const std::byte* at, bool normalized) {
  const auto value = static_cast<float>(load<T>(at));
  if (!normalized) return value;
  return std::max(value / static_cast<float>(std::numeric_limits<T>::max()), -1.0f);
}

// A type of the numbers of an accessor.
struct Component {
  std::size_t bytes;  // 0: cannot be read
  float (*convert)(const std::byte* at, bool normalized);
};
// From TINYGLTF_COMPONENT_TYPE_BYTE on. 32-bit signed integers do not exist in glTF.
constexpr Component kComponents[] = {{1, number<std::int8_t>},
                                     {1, number<std::uint8_t>},
                                     {2, number<std::int16_t>},
                                     {2, number<std::uint16_t>},
                                     {0, nullptr},
                                     {4, number<std::uint32_t>},
                                     {4, nullptr}};

Component component_of(int type) {
  const int index = type - TINYGLTF_COMPONENT_TYPE_BYTE;
  const bool known = index >= 0 && index < static_cast<int>(std::size(kComponents));
  return known ? kComponents[index] : Component{0, nullptr};
}

std::string first_line(const std::string& text) {
  return text.substr(0, std::min(text.find_first_of("\r\n"), std::size_t{200}));
}

// Reads buffers: the binary chunk of a .glb, data URIs, and files beside the scene.
class BufferReader {
 public:
  BufferReader(const std::filesystem::path& path,
               std::optional<std::span<const std::byte>> binary_chunk)
      : path_(path), name_(path.string()), binary_chunk_(binary_chunk) {
    if (binary_chunk) result_.bytes = binary_chunk->size();
  }

  // Adds buffer `i` of the file. Throws Error(input).
  void add(const json& buffer, std::size_t i) {
    const std::string where = fmt::format("{}: buffer {}", name_, i);
    if (!buffer.is_object() || !buffer.contains("byteLength") ||
        !buffer["byteLength"].is_number_unsigned()) {
      fail("{} has no byteLength", where);
    }
    const auto length = buffer["byteLength"].get<std::uint64_t>();
    const auto uri = buffer.find("uri");
    if (uri == buffer.end() && (i != 0 || !binary_chunk_))
      fail("{} has no bytes: neither a uri nor a binary chunk", where);
    const auto bytes = uri == buffer.end() ? *binary_chunk_ : bytes_at(*uri, where);
    if (length > bytes.size()) {
      fail("{}: cut off: {} bytes are announced, there are {}", where, length, bytes.size());
    }
    result_.buffers.push_back(bytes.first(length));
  }

  GltfBuffers take() { return std::move(result_); }

 private:
  std::span<const std::byte> bytes_at(const json& uri, const std::string& where) {
    if (!uri.is_string()) fail("{} has a uri that is no text", where);
    const auto& name = uri.get_ref<const std::string&>();
    if (name.starts_with("data:")) return keep(decode_data_uri(name, where));
    if (name.find('%') != name.npos) {
      fail("{}: unsafe file name '{}': no file name may have a %", where, name.substr(0, 80));
    }
    return file_named(name);
  }

  std::span<const std::byte> file_named(const std::string& stored_name) {
    const std::string name = checked_file_name(stored_name, name_);
    if (const auto known = files_.find(name); known != files_.end()) return known->second;
    const auto bytes = keep(files_beside(path_)->read(name, kMaxBufferBytes));
    result_.bytes_outside += bytes.size();
    return files_[name] = bytes;
  }

  std::span<const std::byte> keep(Array<std::byte> bytes) {
    result_.bytes += bytes.size();
    return result_.unpacked.emplace_back(std::move(bytes));
  }

  const std::filesystem::path& path_;
  std::string name_;
  std::optional<std::span<const std::byte>> binary_chunk_;
  // Many buffers may name one file, which is read only once.
  std::map<std::string, std::span<const std::byte>> files_;
  GltfBuffers result_;
};

// The model of the file's JSON, without the lists that nothing here reads.
tinygltf::Model parse_model(json root, const std::string& path) {
  for (const char* unused : {"buffers", "images", "textures", "samplers", "materials", "animations",
                             "skins", "cameras"}) {
    root.erase(unused);
  }
  const std::string description = root.dump(-1, ' ', false, json::error_handler_t::replace);
  tinygltf::TinyGLTF parser;
  tinygltf::Model model;
  std::string error, warning;
  if (!parser.LoadASCIIFromString(&model, &error, &warning, description.data(),
                                  static_cast<unsigned int>(description.size()), "")) {
    fail("{}: not valid glTF: {}", path, error.empty() ? "unknown reason" : first_line(error));
  }
  return model;
}

}  // namespace

GltfFile::GltfFile(std::span<const std::byte> content, const std::filesystem::path& path)
    : path_(path.string()), is_binary_(is_glb(content)) {
  const Chunks chunks = is_binary_ ? open_glb(content, path_) : Chunks{text_of(content), {}};
  json root = parse_json(chunks.description, path_, kMaxValues);
  if (!root.is_object()) fail("{}: not a glTF file: its JSON is not an object", path_);
  check_layout(root, path_);

  // The buffers are read here, tinygltf gets the rest.
  json buffers = json::array();
  if (root.contains("buffers")) buffers.swap(root["buffers"]);
  if (!buffers.is_array()) fail("{}: buffers is not a list", path_);
  BufferReader reader(path, is_binary_ ? std::optional(chunks.binary) : std::nullopt);
  for (std::size_t i = 0; i < buffers.size(); ++i) reader.add(buffers[i], i);
  buffers_ = reader.take();
  model_ = parse_model(std::move(root), path_);
}

std::span<const std::byte> GltfFile::view(int index) const {
  if (index < 0 || static_cast<std::size_t>(index) >= model_.bufferViews.size()) {
    fail("{}: bufferView {} does not exist", path_, index);
  }
  const tinygltf::BufferView& view = model_.bufferViews[static_cast<std::size_t>(index)];
  if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= buffers_.buffers.size()) {
    fail("{}: buffer {} does not exist", path_, view.buffer);
  }
  const auto& buffer = buffers_.buffers[static_cast<std::size_t>(view.buffer)];
  if (view.byteOffset > buffer.size() || view.byteLength > buffer.size() - view.byteOffset) {
    fail("{}: bufferView {} reaches beyond its buffer of {} bytes", path_, index, buffer.size());
  }
  return buffer.subspan(view.byteOffset, view.byteLength);
}

const tinygltf::Accessor& GltfFile::accessor(int index, const std::string& what) const {
  if (index < 0 || static_cast<std::size_t>(index) >= model_.accessors.size()) {
    fail("{}: {}: accessor {} does not exist", path_, what, index);
  }
  return model_.accessors[static_cast<std::size_t>(index)];
}

std::uint64_t GltfFile::count(int index, const std::string& what) const {
  return accessor(index, what).count;
}

GltfNumbers GltfFile::numbers(int index, std::size_t components, const std::string& what) const {
  const tinygltf::Accessor& accessor = this->accessor(index, what);
  if (accessor.sparse.isSparse) fail("{}: {}: sparse accessors cannot be read", path_, what);
  GltfNumbers numbers;
  const Component component = component_of(accessor.componentType);
  numbers.component_bytes_ = component.bytes;
  if (numbers.component_bytes_ == 0 || accessor.type < 0 ||
      tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)) !=
          static_cast<int>(components)) {
    fail("{}: {}: not {} numbers of a known type", path_, what, components);
  }
  const auto bytes = view(accessor.bufferView);
  const std::uint64_t element_bytes = components * numbers.component_bytes_;
  const std::uint64_t stride =
      model_.bufferViews[static_cast<std::size_t>(accessor.bufferView)].byteStride;
  numbers.stride_ = stride == 0 ? element_bytes : stride;
  if (numbers.stride_ < element_bytes || accessor.byteOffset > bytes.size() ||
      accessor.count == 0 || bytes.size() - accessor.byteOffset < element_bytes ||
      !fits(accessor.count - 1, numbers.stride_,
            bytes.size() - accessor.byteOffset - element_bytes)) {
    fail("{}: {}: {} elements do not fit into bufferView {} of {} bytes", path_, what,
         accessor.count, accessor.bufferView, bytes.size());
  }
  numbers.count = accessor.count;
  numbers.data_ = bytes.data() + accessor.byteOffset;
  numbers.convert_ = component.convert;
  numbers.normalized_ = accessor.normalized;
  return numbers;
}

bool is_glb(std::span<const std::byte> content) { return text_of(content).starts_with("glTF"); }

}  // namespace qs
