// SPDX-License-Identifier: MIT
#include "io/scene/gltf/gltf_file.h"

#include <algorithm>
#include <array>
#include <cmath>
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

GltfNumbers GltfFile::numbers(int index, std::size_t components, const std::string& what) const {
  const tinygltf::Accessor& accessor = this->accessor(index, what);
  if (accessor.sparse.isSparse) fail("{}: {}: sparse accessors cannot be read", path_, what);
  const Component component = component_of(accessor.componentType);
  if (component.bytes == 0 || accessor.type < 0 ||
      tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)) !=
          static_cast<int>(components))
    fail("{}: {}: not {} numbers of a known type", path_, what, components);
  const auto bytes = view(accessor.bufferView);
  const std::uint64_t element_bytes = components * component.bytes;
  const std::uint64_t stated =
      model_.bufferViews[static_cast<std::size_t>(accessor.bufferView)].byteStride;
  const std::uint64_t stride = stated == 0 ? element_bytes : stated;
  if (stride < element_bytes || accessor.byteOffset > bytes.size() || accessor.count == 0 ||
      bytes.size() - accessor.byteOffset < element_bytes ||
      !fits(accessor.count - 1, stride, bytes.size() - accessor.byteOffset - element_bytes))
    fail("{}: {}: {} elements do not fit into bufferView {} of {} bytes", path_, what,
         accessor.count, accessor.bufferView, bytes.size());
  return {accessor.count,
          bytes.data() + accessor.byteOffset,
          stride,
          component.bytes,
          component.convert,
          accessor.normalized};
}

bool is_glb(ByteSpan content) { return text_of(content).starts_with("glTF"); }

void fill_gaussian(const GltfSplats& splats, std::uint64_t from, GaussianCloud& cloud,
                   std::size_t to, GltfClamped& clamped) {
  glm::vec3* const sh = sh_of(cloud, to);
  std::fill_n(sh, sh_count(cloud), glm::vec3(0));
  if (splats.cloud) return copy_gaussian(*splats.cloud, from, cloud, to);
  const auto vector = [from](const GltfNumbers& numbers) {
    return glm::vec3(numbers(from, 0), numbers(from, 1), numbers(from, 2));
  };
  cloud.positions[to] = vector(splats.positions);
  const GltfNumbers& q = splats.rotations;
  cloud.rotations[to] = glm::quat(q(from, 3), q(from, 0), q(from, 1), q(from, 2));
  glm::vec3 scale = vector(splats.scales);
  if (!splats.scales_are_logarithms) {
    if (scale.x < 0 || scale.y < 0 || scale.z < 0) ++clamped.scales;
    scale = glm::log(glm::max(scale, glm::vec3(0)));
  }
  cloud.log_scales[to] = scale;
  const bool has_colors = splats.colors.count > 0;
  const double opacity = has_colors ? splats.colors(from, 3) : splats.opacities(from, 0);
  if (opacity < 0 || opacity > 1) ++clamped.opacities;
  const double inside = opacity < 0 ? 0 : opacity > 1 ? 1 : opacity;  // NaN stays
  cloud.opacity_logits[to] = static_cast<float>(std::log(inside / (1 - inside)));
  if (has_colors) sh[0] = (vector(splats.colors) - 0.5f) / static_cast<float>(kSh0);
  const std::size_t first = has_colors ? 1 : 0;
  for (std::size_t k = 0; k < splats.sh.size(); ++k) sh[first + k] = vector(splats.sh[k]);
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
