// SPDX-License-Identifier: MIT
#include <cmath>
#include <functional>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/axes.h"
#include "io/cloud/cloud_memory.h"
#include "io/scene/gltf/gltf.h"
#include "raster/scene/activated_cloud.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

// One accessor: the first `components` floats of value(i) for every Gaussian i.
struct Attribute {
  std::string name;
  glm::length_t components;
  std::function<glm::vec4(std::size_t i)> value;
};

// The attributes of a cloud that outlives them.
std::vector<Attribute> attributes_of(const GaussianCloud& cloud) {
  const std::string prefix = "KHR_gaussian_splatting:";
  const auto position = [&](std::size_t i) { return glm::vec4(cloud.positions[i], 0); };
  const auto rotation = [&](std::size_t i) {
    const glm::quat& q = cloud.rotations[i];
    return glm::vec4(q.x, q.y, q.z, q.w);
  };
  const auto scale = [&](std::size_t i) {
    return glm::vec4(glm::vec3(glm::exp(glm::dvec3(cloud.log_scales[i]))), 0);
  };
  const auto opacity = [&](std::size_t i) {
    return glm::vec4(static_cast<float>(opacity_of_logit(cloud.opacity_logits[i])));
  };
  std::vector<Attribute> attributes = {{"POSITION", 3, position},
                                       {prefix + "ROTATION", 4, rotation},
                                       {prefix + "SCALE", 3, scale},
                                       {prefix + "OPACITY", 1, opacity}};
  std::size_t number = 0;
  for (int degree = 0; degree <= cloud.sh_degree; ++degree)
    for (int k = 0; k < 2 * degree + 1; ++k, ++number)
      attributes.push_back(
          {fmt::format("{}SH_DEGREE_{}_COEF_{}", prefix, degree, k), 3,
           [&cloud, number](std::size_t i) { return glm::vec4(sh_of(cloud, i)[number], 0); }});
  return attributes;
}

std::uint64_t bytes_of(const Attribute& attribute, const GaussianCloud& cloud) {
  return cloud.size() * static_cast<std::size_t>(attribute.components) * sizeof(float);
}

ordered_json description_of(const GaussianCloud& cloud, const std::vector<Attribute>& attributes) {
  constexpr int kFloat = 5126, kVertices = 34962, kPoints = 0;
  glm::vec3 low(std::numeric_limits<float>::infinity()), high = -low;
  for (const glm::vec3& position : cloud.positions) {
    low = glm::min(low, position);
    high = glm::max(high, position);
  }
  ordered_json views = ordered_json::array(), accessors = ordered_json::array(),
               names = ordered_json::object();
  std::uint64_t offset = 0;
  for (const Attribute& attribute : attributes) {
    const std::uint64_t bytes = bytes_of(attribute, cloud);
    const char* const type = attribute.components == 1   ? "SCALAR"
                             : attribute.components == 3 ? "VEC3"
                                                         : "VEC4";
    names[attribute.name] = accessors.size();
    ordered_json accessor = {{"bufferView", views.size()},
                             {"componentType", kFloat},
                             {"count", cloud.size()},
                             {"type", type}};
    if (offset == 0) {
      accessor["min"] = {low.x, low.y, low.z};
      accessor["max"] = {high.x, high.y, high.z};
    }
    accessors.push_back(accessor);
    views.push_back(
        {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}, {"target", kVertices}});
    offset += bytes;
  }
  const ordered_json extension = {{"kernel", "ellipse"},
                                  {"colorSpace", "srgb_rec709_display"},
                                  {"projection", "perspective"},
                                  {"sortingMethod", "cameraDistance"}};
  const ordered_json primitive = {{"attributes", names},
                                  {"mode", kPoints},
                                  {"extensions", {{"KHR_gaussian_splatting", extension}}}};
  return {{"asset", {{"version", "2.0"}, {"generator", "quadsplat"}}},
          {"extensionsUsed", {"KHR_gaussian_splatting"}},
          {"scene", 0},
          {"scenes", {{{"nodes", {0}}}}},
          {"nodes", {{{"mesh", 0}}}},
          {"meshes", {{{"primitives", {primitive}}}}},
          {"accessors", accessors},
          {"bufferViews", views},
          {"buffers", {{{"byteLength", offset}}}}};
}

}  // namespace

void write_glb(const GaussianCloud& rdf_cloud, const std::filesystem::path& path, ThreadPool&,
               const Progress& progress) {
  constexpr std::uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A, kBinary = 0x004E4942;
  GaussianCloud cloud = rdf_cloud;
  flip_axes(cloud, 0, cloud.size(), kTurnAboutZ);
  const std::vector<Attribute> attributes = attributes_of(cloud);
  std::uint64_t binary_bytes = 0;
  for (const Attribute& attribute : attributes) binary_bytes += bytes_of(attribute, cloud);
  std::string text = description_of(cloud, attributes).dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::uint64_t total = 12 + 8 + text.size() + 8 + binary_bytes;
  if (total > 0xffffffff)
    fail("{}: {} bytes are more than the 4 GiB that a .glb can have", path.string(), total);

  const auto bits32 = [](std::uint64_t number) { return static_cast<std::uint32_t>(number); };
  write_file(path, [&](std::ostream& file) {
    write_values(file, std::array{kMagic, 2u, bits32(total), bits32(text.size()), kJson});
    file << text;
    write_values(file, std::array{bits32(binary_bytes), kBinary});
    std::vector<float> values;
    for (std::size_t a = 0; a < attributes.size(); ++a) {
      progress.update(static_cast<float>(a) / static_cast<float>(attributes.size()));
      values.clear();
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        const glm::vec4 value = attributes[a].value(i);
        values.insert(values.end(), &value.x, &value.x + attributes[a].components);
      }
      write_values(file, values);
    }
  });
  progress.update(1);
}

}  // namespace qs
