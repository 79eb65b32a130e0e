// SPDX-License-Identifier: MIT
#include "io/scene/gltf/gltf_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "io/bytes/base64.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/file_source.h"
#include "io/bytes/json_text.h"
#include "io/cloud/cloud_memory.h"
#include "raster/kernel/constants.h"

namespace qs {
namespace {

using json = nlohmann::json;

constexpr std::size_t kMaxValues = 1 << 20;
constexpr std::uint64_t kMaxBufferBytes = std::uint64_t{1} << 36;

// The two chunks of a .glb.
struct Chunks {
  std::string_view description;
  ByteSpan binary;
};

Chunks open_glb(ByteSpan content, const std::string& path) {
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
  if (cursor.read<std::uint32_t>("the first chunk") != kJson)
    fail("{}: the first chunk is not JSON", path);
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

// The model of the file's JSON, without the lists that nothing here reads.
tinygltf::Model parse_model(json root, const std::string& path) {
  for (const char* unused :
       {"buffers", "images", "textures", "samplers", "materials", "animations", "skins", "cameras"})
    root.erase(unused);
  const std::string description = root.dump(-1, ' ', false, json::error_handler_t::replace);
  tinygltf::TinyGLTF parser;
  tinygltf::Model model;
  std::string error, warning;
  if (!parser.LoadASCIIFromString(&model, &error, &warning, description.data(),
                                  static_cast<unsigned int>(description.size()), ""))
    fail("{}: not valid glTF: {}", path, error.empty() ? "unknown reason" : first_line(error));
  return model;
}

std::size_t checked(int index, std::size_t count, const char* what, const std::string& source) {
  if (index < 0 || static_cast<std::size_t>(index) >= count)
    fail("{}: {} {} does not exist", source, what, index);
  return static_cast<std::size_t>(index);
}

glm::dmat4 parent_from_node(const tinygltf::Node& node, int number, const std::string& source) {
  const auto has = [&](const std::vector<double>& values, std::size_t count, const char* what) {
    if (!values.empty() && values.size() != count)
      fail("{}: node {}: {} has {} numbers instead of {}", source, number, what, values.size(),
           count);
    return !values.empty();
  };
  glm::dmat4 matrix(1);
  if (has(node.matrix, 16, "matrix")) {
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
    return matrix;
  }
  if (has(node.translation, 3, "translation")) {
    const auto& t = node.translation;
    matrix = glm::translate(matrix, glm::dvec3(t[0], t[1], t[2]));
  }
  if (has(node.rotation, 4, "rotation")) {
    const auto& r = node.rotation;  // x y z w
    matrix *= glm::mat4_cast(glm::normalize(glm::dquat(r[3], r[0], r[1], r[2])));
  }
  if (has(node.scale, 3, "scale")) {
    const auto& s = node.scale;
    matrix = glm::scale(matrix, glm::dvec3(s[0], s[1], s[2]));
  }
  return matrix;
}

// The root nodes of the default scene; without scenes, all nodes that are not a child of another
// node.
std::vector<int> root_nodes(const tinygltf::Model& model, const std::string& source) {
  if (!model.scenes.empty()) {
    const int scene = model.defaultScene < 0 ? 0 : model.defaultScene;
    return model.scenes[checked(scene, model.scenes.size(), "scene", source)].nodes;
  }
  std::vector<bool> is_child(model.nodes.size());
  for (const tinygltf::Node& node : model.nodes)
    for (const int child : node.children)
      is_child[checked(child, model.nodes.size(), "node", source)] = true;
  std::vector<int> roots;
  for (std::size_t i = 0; i < is_child.size(); ++i)
    if (!is_child[i]) roots.push_back(static_cast<int>(i));
  return roots;
}

}  // namespace

GltfFile::GltfFile(ByteSpan content, const std::filesystem::path& path)
    : file_(path), path_(path.string()), is_binary_(is_glb(content)) {
  const Chunks chunks = is_binary_ ? open_glb(content, path_) : Chunks{text_of(content), {}};
  json root = parse_json(chunks.description, path_, kMaxValues);
  if (!root.is_object()) fail("{}: not a glTF file: its JSON is not an object", path_);
  check_layout(root, path_);

  // The buffers are read here, tinygltf gets the rest.
  json buffers = json::array();
  if (root.contains("buffers")) buffers.swap(root["buffers"]);
  if (!buffers.is_array()) fail("{}: buffers is not a list", path_);
  buffer_bytes_ = chunks.binary.size();
  const auto chunk = is_binary_ ? std::optional(chunks.binary) : std::nullopt;
  for (const json& buffer : buffers) add_buffer(buffer, chunk);
  model_ = parse_model(std::move(root), path_);
}

// The bytes are the binary chunk of a .glb, in a data URI, or in a file beside the scene.
void GltfFile::add_buffer(const json& buffer, std::optional<ByteSpan> binary_chunk) {
  const std::string where = fmt::format("{}: buffer {}", path_, buffers_.size());
  if (!buffer.is_object() || !buffer.contains("byteLength") ||
      !buffer["byteLength"].is_number_unsigned())
    fail("{} has no byteLength", where);
  const auto length = buffer["byteLength"].get<std::uint64_t>();
  const auto uri = buffer.find("uri");
  if (uri == buffer.end() && (!buffers_.empty() || !binary_chunk))
    fail("{} has no bytes: neither a uri nor a binary chunk", where);
  const auto bytes = uri == buffer.end() ? *binary_chunk : bytes_at(*uri, where);
  if (length > bytes.size())
    fail("{}: cut off: {} bytes are announced, there are {}", where, length, bytes.size());
  buffers_.push_back(bytes.first(length));
}

ByteSpan GltfFile::bytes_at(const json& uri, const std::string& where) {
  if (!uri.is_string()) fail("{} has a uri that is no text", where);
  const auto& stored_name = uri.get_ref<const std::string&>();
  if (stored_name.starts_with("data:")) return keep(decode_data_uri(stored_name, where));
  if (stored_name.find('%') != stored_name.npos)
    fail("{}: unsafe file name '{}': no file name may have a %", where, stored_name.substr(0, 80));
  const std::string name = checked_file_name(stored_name, path_);
  if (const auto known = outside_.find(name); known != outside_.end()) return known->second;
  const ByteSpan bytes = keep(files_beside(file_)->read(name, kMaxBufferBytes));
  bytes_outside_ += bytes.size();
  return outside_[name] = bytes;
}

ByteSpan GltfFile::keep(Array<std::byte> bytes) {
  buffer_bytes_ += bytes.size();
  return unpacked_.emplace_back(std::move(bytes));
}

ByteSpan GltfFile::view(int index) const {
  if (index < 0 || static_cast<std::size_t>(index) >= model_.bufferViews.size())
    fail("{}: bufferView {} does not exist", path_, index);
  const tinygltf::BufferView& view = model_.bufferViews[static_cast<std::size_t>(index)];
  if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= buffers_.size())
    fail("{}: buffer {} does not exist", path_, view.buffer);
  const auto& buffer = buffers_[static_cast<std::size_t>(view.buffer)];
  if (view.byteOffset > buffer.size() || view.byteLength > buffer.size() - view.byteOffset)
    fail("{}: bufferView {} reaches beyond its buffer of {} bytes", path_, index, buffer.size());
  return buffer.subspan(view.byteOffset, view.byteLength);
}

const tinygltf::Accessor& GltfFile::accessor(int index, const std::string& what) const {
  if (index < 0 || static_cast<std::size_t>(index) >= model_.accessors.size())
    fail("{}: {}: accessor {} does not exist", path_, what, index);
  return model_.accessors[static_cast<std::size_t>(index)];
}

std::uint64_t GltfFile::count(int index, const std::string& what) const {
  return accessor(index, what).count;
}

// The first of `count` elements in a bufferView, all of which lie in it.
const std::byte* GltfFile::elements(int index, std::uint64_t offset, std::uint64_t count,
                                    std::uint64_t element_bytes, std::uint64_t stride,
                                    const std::string& what) const {
  const auto bytes = view(index);
  if (stride < element_bytes || offset > bytes.size() || count == 0 ||
      bytes.size() - offset < element_bytes ||
      !fits(count - 1, stride, bytes.size() - offset - element_bytes))
    fail("{}: {}: {} elements do not fit into bufferView {} of {} bytes", path_, what, count, index,
         bytes.size());
  return bytes.data() + offset;
}

// A sparse accessor replaces some elements of its bufferView, or of zeros without one.
void GltfFile::replace_sparse(const tinygltf::Accessor& accessor, std::uint64_t element_bytes,
                              const std::string& what, GltfNumbers& numbers) const {
  constexpr std::uint64_t kAlwaysAllowed = 1 << 20, kPerByte = 8;
  const auto& sparse = accessor.sparse;
  if (numbers.data == nullptr &&
      accessor.count > std::max(kAlwaysAllowed, kPerByte * buffer_bytes_))
    fail("{}: {}: {} elements without values are more than a file of {} bytes needs", path_, what,
         accessor.count, buffer_bytes_);
  if (sparse.count < 1 || static_cast<std::uint64_t>(sparse.count) > accessor.count ||
      sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
    fail("{}: {}: {} of {} elements cannot be replaced", path_, what, sparse.count, accessor.count);
  const Component index_type = component_of(sparse.indices.componentType);
  const bool is_unsigned = sparse.indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                           sparse.indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                           sparse.indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  if (!is_unsigned) fail("{}: {}: its sparse indices are no unsigned integers", path_, what);
  const auto count = static_cast<std::uint64_t>(sparse.count);
  const auto offset = [](int bytes) { return static_cast<std::uint64_t>(bytes); };
  const std::byte* const indices =
      elements(sparse.indices.bufferView, offset(sparse.indices.byteOffset), count,
               index_type.bytes, index_type.bytes, what + " (sparse indices)");
  const std::byte* const values =
      elements(sparse.values.bufferView, offset(sparse.values.byteOffset), count, element_bytes,
               element_bytes, what + " (sparse values)");

  auto dense = std::make_shared<Array<std::byte>>();
  dense->resize(accessor.count * element_bytes);
  std::ranges::fill(*dense, std::byte{0});
  for (std::uint64_t i = 0; numbers.data != nullptr && i < accessor.count; ++i)
    std::copy_n(numbers.data + i * numbers.stride, element_bytes,
                dense->data() + i * element_bytes);
  for (std::uint64_t i = 0; i < count; ++i) {
    std::uint32_t place = 0;
    std::memcpy(&place, indices + i * index_type.bytes, index_type.bytes);
    if (place >= accessor.count)
      fail("{}: {}: its sparse index {} is not below {}", path_, what, place, accessor.count);
    std::copy_n(values + i * element_bytes, element_bytes, dense->data() + place * element_bytes);
  }
  numbers.data = dense->data();
  numbers.stride = element_bytes;
  numbers.dense = std::move(dense);
}

GltfNumbers GltfFile::numbers(int index, std::size_t components, const std::string& what) const {
  const tinygltf::Accessor& accessor = this->accessor(index, what);
  const Component component = component_of(accessor.componentType);
  if (component.bytes == 0 || accessor.type < 0 ||
      tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)) !=
          static_cast<int>(components))
    fail("{}: {}: not {} numbers of a known type", path_, what, components);
  const std::uint64_t element_bytes = components * component.bytes;
  GltfNumbers numbers{.count = accessor.count,
                      .stride = element_bytes,
                      .component_bytes = component.bytes,
                      .convert = component.convert,
                      .normalized = accessor.normalized};
  if (accessor.bufferView >= 0 || !accessor.sparse.isSparse) {
    view(accessor.bufferView);  // it exists
    const std::uint64_t stated =
        model_.bufferViews[static_cast<std::size_t>(accessor.bufferView)].byteStride;
    if (stated != 0) numbers.stride = stated;
    numbers.data = elements(accessor.bufferView, accessor.byteOffset, accessor.count, element_bytes,
                            numbers.stride, what);
  }
  if (accessor.sparse.isSparse) replace_sparse(accessor, element_bytes, what, numbers);
  return numbers;
}

bool is_glb(ByteSpan content) { return text_of(content).starts_with("glTF"); }

namespace {

// The transfer function of sRGB, IEC 61966-2-1, continued below 0.
double srgb_of_linear(double value) {
  return value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

// Converts linear colours to sRGB: the base colour exactly, and the other coefficients by the
// function's slope over their rms in all directions.
void convert_to_srgb(glm::vec3* sh, std::size_t count) {
  for (int c = 0; c < 3; ++c) {
    const double base = 0.5 + kSh0 * static_cast<double>(sh[0][c]);
    double square = 0;
    for (std::size_t k = 1; k < count; ++k) square += std::pow(static_cast<double>(sh[k][c]), 2);
    const double rms = kSh0 * std::sqrt(square);
    const double slope =
        rms > 0 ? (srgb_of_linear(base + rms) - srgb_of_linear(base - rms)) / (2 * rms) : 1;
    sh[0][c] = static_cast<float>((srgb_of_linear(base) - 0.5) / kSh0);
    for (std::size_t k = 1; k < count; ++k) sh[k][c] *= static_cast<float>(slope);
  }
}

}  // namespace

void fill_gaussian(const GltfSplats& splats, std::uint64_t from, GaussianCloud& cloud,
                   std::size_t to, LinearValues& linear) {
  glm::vec3* const sh = sh_of(cloud, to);
  std::fill_n(sh, sh_count(cloud), glm::vec3(0));
  if (splats.cloud) {
    copy_gaussian(*splats.cloud, from, cloud, to);
    if (splats.colors_are_linear) convert_to_srgb(sh, sh_count(*splats.cloud));
    return;
  }
  const auto vector = [from](const GltfNumbers& numbers) {
    return glm::vec3(numbers(from, 0), numbers(from, 1), numbers(from, 2));
  };
  cloud.positions[to] = vector(splats.positions);
  const GltfNumbers& q = splats.rotations;
  cloud.rotations[to] = glm::quat(q(from, 3), q(from, 0), q(from, 1), q(from, 2));
  const glm::vec3 scale = vector(splats.scales);
  cloud.log_scales[to] = splats.scales_are_logarithms ? scale : linear.log_scale(scale);
  const bool has_colors = splats.colors.count > 0;
  cloud.opacity_logits[to] =
      linear.logit(has_colors ? splats.colors(from, 3) : splats.opacities(from, 0));
  if (has_colors) sh[0] = (vector(splats.colors) - 0.5f) / static_cast<float>(kSh0);
  const std::size_t first = has_colors ? 1 : 0;
  for (std::size_t k = 0; k < splats.sh.size(); ++k) sh[first + k] = vector(splats.sh[k]);
  if (splats.colors_are_linear) convert_to_srgb(sh, first + splats.sh.size());
}

// In the draft most scales of trained Gaussians are negative, because they are logarithms of
// numbers below 1. A linear writer produces only occasional negative values.
bool are_logarithms(const GltfNumbers& scales) {
  std::uint64_t negative = 0;
  for (std::uint64_t i = 0; i < scales.count; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) negative += scales(i, axis) < 0 ? 1 : 0;
  return negative > scales.count * 3 / 2;
}

std::vector<PlacedMesh> placed_meshes(const tinygltf::Model& model, const std::string& source) {
  std::vector<PlacedMesh> placed;
  if (model.nodes.empty()) {
    for (std::size_t i = 0; i < model.meshes.size(); ++i) placed.push_back({i, -1, glm::dmat4(1)});
    return placed;
  }
  struct Visit {
    int node;
    glm::dmat4 world_from_parent;
  };
  std::vector<Visit> pending;
  for (const int root : root_nodes(model, source)) pending.push_back({root, glm::dmat4(1)});
  std::vector<bool> visited(model.nodes.size());
  while (!pending.empty()) {
    const Visit visit = pending.back();
    pending.pop_back();
    const std::size_t index = checked(visit.node, model.nodes.size(), "node", source);
    if (visited[index]) fail("{}: its nodes are no tree: node {} is met twice", source, index);
    visited[index] = true;
    const tinygltf::Node& node = model.nodes[index];
    const glm::dmat4 world = visit.world_from_parent * parent_from_node(node, visit.node, source);
    if (node.mesh >= 0)
      placed.push_back(
          {checked(node.mesh, model.meshes.size(), "mesh", source), visit.node, world});
    for (const int child : node.children) pending.push_back({child, world});
  }
  return placed;
}

}  // namespace qs
