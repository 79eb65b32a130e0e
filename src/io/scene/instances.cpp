// SPDX-License-Identifier: MIT
// Compiled alone: tests/new_format replaces the tables of readers and writers, and their unit with
// them.
#include "io/scene/instances.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "io/bytes/file_source.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/bytes/mapped_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/scene/reader.h"
#include "raster/kernel/constants.h"
#include "raster/scene/place.h"
#include "raster/scene/transform.h"

namespace qs {
namespace {

Instance parse_instance(const JsonEntry& entry) {
  Instance instance;
  if (entry.has("position")) instance.position = entry.vector<3>("position");
  if (entry.has("rotation")) {
    const glm::dvec4 q = entry.vector<4>("rotation");
    if (!(glm::length(q) > 1e-9 && glm::length(q) < 1e9))
      fail("{}: rotation has no direction", entry.where);
    instance.rotation = glm::normalize(glm::dquat(q.x, q.y, q.z, q.w));
  }
  if (entry.has("scale")) instance.scale = entry.number("scale");
  if (!(instance.scale >= 1e-9 && instance.scale <= 1e9))
    fail("{}: scale is {}, but must be within 1e-9 and 1e9", entry.where, instance.scale);
  if (entry.has("tint")) instance.tint = entry.vector<3>("tint");
  for (int channel = 0; channel < 3; ++channel)
    if (!(instance.tint[channel] >= 0 && instance.tint[channel] <= 1000))
      fail("{}: tint is {}, but must be within 0 and 1000", entry.where, instance.tint[channel]);
  return instance;
}

// `unknown` receives the names of members that no instance has.
std::vector<Instance> parse_instances(const nlohmann::json& list, const std::string& source,
                                      std::set<std::string>& unknown) {
  if (!list.is_array() || list.empty()) fail("{}: instances is not a list of objects", source);
  static const std::set<std::string> kMembers = {"position", "rotation", "scale", "tint"};
  std::vector<Instance> instances;
  for (const nlohmann::json& each : list) {
    const std::string where = fmt::format("{}: instance {}", source, instances.size());
    if (!each.is_object()) fail("{}: is not an object", where);
    for (const auto& [name, value] : each.items())
      if (!kMembers.contains(name)) unknown.insert(printable(name));
    instances.push_back(parse_instance({each, where}));
  }
  return instances;
}

// The scene's file, which is no file of instances itself.
std::filesystem::path find_source(const std::string& name, const std::string& source) {
  const auto file = std::filesystem::path(source).parent_path() / checked_file_name(name, source);
  if (!std::filesystem::is_regular_file(file))
    fail("{}: the scene {} that it names is missing", source, printable(name));
  if (recognises_instances(MappedFile(file).content(), file))
    fail("{}: its scene {} consists of instances too", source, printable(name));
  return file;
}

void require_memory(const Scene& one, std::size_t instances, const std::string& source) {
  const std::uint64_t count = instances * one.cloud.size();   // below 2^25 * 2^32
  const std::uint64_t floats = 11 + 3 * sh_count(one.cloud);  // of a Gaussian
  const std::uint64_t bytes = 2 * count * floats * sizeof(float);
  const std::string what =
      fmt::format("{}: {} of {} are {}", source, counted(instances, "instance"),
                  one.path.filename().string(), counted(count, "Gaussian"));
  if (const std::uint64_t free = available_memory(); bytes > free)
    fail(ErrorKind::device, "{}, which take {} to draw; {} of memory are available", what,
         bytes_text(bytes), bytes_text(free));
  if (count > 0x7fffffff) fail(ErrorKind::device, "{}, more than 2^31 - 1", what);
}

}  // namespace

glm::dmat4 matrix_of(const Instance& instance, const glm::dvec3& from, const glm::dvec3& to) {
  return glm::translate(glm::dmat4(1), -to) * glm::translate(glm::dmat4(1), instance.position) *
         glm::mat4_cast(instance.rotation) * glm::scale(glm::dmat4(1), glm::dvec3(instance.scale)) *
         glm::translate(glm::dmat4(1), from);
}

void place_instance(const GaussianCloud& source, const Instance& instance, GaussianCloud& cloud,
                    std::size_t first, ThreadPool& pool) {
  const Placement placement{Transform(matrix_of(instance, source.origin, cloud.origin)),
                            instance.tint};
  pool.for_each(source.size(), 1024, [&](std::size_t i) {
    copy_gaussian(source, i, cloud, first + i);
    placement.apply(cloud, first + i);
  });
}

bool recognises_instances(ByteSpan content, const std::filesystem::path&) {
  return json_kind(text_of(content)) == JsonKind::instances;
}

InstanceList read_instance_list(ByteSpan content, const std::filesystem::path& path) {
  InstanceList list;
  list.path = path;
  const std::string source = path.string();
  const nlohmann::json json = parse_json(text_of(content), source);
  if (!json.is_object()) fail("{}: is not an object", source);
  const JsonEntry entry{json, source};
  if (const auto version = entry.whole("version"); version != 1)
    fail("{}: version {}, only 1 exists", source, version);
  std::set<std::string> unknown;
  list.instances = parse_instances(entry.get("instances"), source, unknown);
  list.scene = find_source(entry.text("scene"), source);
  for (const std::string& member : unknown)
    list.warnings.push_back(
        fmt::format("The member '{}' of instances is not known and was ignored.", member));
  return list;
}

InstanceFile open_instances(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                            const ReadOptions& options) {
  InstanceFile file{read_instance_list(content, path), {}};
  ReadOptions own;
  own.progress = {[&](float done) { options.progress.update(done / 2); }, options.progress.stop};
  file.one = read_scene(file.scene, pool, own);
  const std::string name = file.one.path.filename().string();
  std::vector<std::string> warnings;
  for (const std::string& warning : file.one.warnings)
    warnings.push_back(fmt::format("{}: {}", name, warning));
  if (file.one.network)
    warnings.push_back(fmt::format("The colours of the network of {} were not used.", name));
  file.warnings.insert(file.warnings.begin(), warnings.begin(), warnings.end());
  return file;
}

void fill_instances(const InstanceFile& file, std::size_t begin, std::size_t end, ThreadPool& pool,
                    const Progress& progress, Scene& scene) {
  const Scene& one = file.one;
  const std::size_t size = one.cloud.size();
  require_memory(one, end - begin, file.path.string());
  scene.cloud = make_cloud((end - begin) * size, one.cloud.sh_degree);
  scene.cloud.antialiased = one.cloud.antialiased;
  scene.cloud.origin = origin_of(file.instances.size(), [&](std::size_t i) {
    return glm::dvec3(matrix_of(file.instances[i], one.cloud.origin) *
                      glm::dvec4(one.cloud.positions[0], 1));
  });
  for (std::size_t i = begin; i < end; ++i) {
    place_instance(one.cloud, file.instances[i], scene.cloud, (i - begin) * size, pool);
    progress.update(0.5f +
                    0.4f * static_cast<float>(i + 1 - begin) / static_cast<float>(end - begin));
  }
  scene.format = "instances of " + one.format;
  scene.file_bytes += one.file_bytes;
  scene.vertical_axis = one.vertical_axis;
  scene.parts.push_back(
      {one.path.filename().string(), one.file_bytes,
       fmt::format("{} of {}", counted(end - begin, "instance"), counted(size, "Gaussian"))});
  for (const std::string& warning : file.warnings) add_new(scene.warnings, warning);
  fill_cloud(scene, pool, progress, 0.9f, [](std::size_t, std::size_t) {});
}

void read_instances(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                    const ReadOptions& options, Scene& scene) {
  const InstanceFile file = open_instances(content, path, pool, options);
  fill_instances(file, 0, file.instances.size(), pool, options.progress, scene);
}

}  // namespace qs
