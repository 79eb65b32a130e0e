// SPDX-License-Identifier: MIT
#include "io/scene/sog/sog.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "io/bytes/byte_text.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/scene/sog/sog_decoder.h"

namespace qs {
namespace {

using json = nlohmann::json;

constexpr const char* kMetaFile = "meta.json";
constexpr std::uint64_t kMaxMetaBytes = 4u << 20, kMaxTreeBytes = 64u << 20;

// Consecutive Gaussians of one decoder.
struct Part {
  SogDecoder* decoder;
  std::uint64_t offset, count;
};

void fill_from(const std::vector<Part>& parts, Scene& scene, ThreadPool& pool,
               const Progress& progress) {
  CloudParts cloud_parts;
  int degree = 0;
  for (const Part& part : parts) {
    cloud_parts.add(part.count);
    degree = std::max(degree, part.decoder->sh_degree());
  }
  scene.cloud = make_cloud(cloud_parts.count(), degree);
  fill_cloud(scene, pool, progress, 0.5f, [&](std::size_t begin, std::size_t end) {
    cloud_parts.for_range(begin, end, [&](std::size_t part, std::uint64_t row, std::size_t i) {
      parts[part].decoder->fill(parts[part].offset + row, scene.cloud, i);
    });
  });
}

void add_warnings(const SogDecoder& decoder, Scene& scene) {
  if (decoder.unrotated() > 0) warn_of_missing_rotations(scene, decoder.unrotated());
  if (decoder.unlabelled() > 0) warn_of_missing_sh(scene, decoder.unlabelled());
}

// Applies the models of all parts, a word each, with which splat-transform names their training.
void apply_models(const std::set<std::string>& models, Scene& scene) {
  scene.cloud.antialiased = models.count("antialiased") > 0;
  if (models.count("2dgs") > 0)
    scene.warn(
        "2D Gaussians (2DGS): they are drawn as flat 3D Gaussians, without 2DGS's intersection of "
        "rays.");
  for (const std::string& model : models)
    if (model != "antialiased" && model != "2dgs" && model != "default")
      scene.warn("The model '{}' is not known: the Gaussians are drawn as usual.",
                 printable(model));
  if (scene.cloud.antialiased && models.size() > 1)
    scene.warn("Some parts were trained antialiased: all of them are drawn so.");
}

// The part of the finest level that a leaf refers to.
struct Leaf {
  std::uint64_t file, offset, count;
};

class Tree {
 public:
  Tree(std::string_view text, const std::string& source)
      : source_(source), root_(parse_json(text, source)) {
    const JsonEntry entry{object(root_), source_};
    const json& names = entry.get("filenames");
    if (!names.is_array()) fail("{}: filenames is not a list", source_);
    for (const json& name : names) {
      if (!name.is_string()) fail("{}: filenames has something else than names", source_);
      files.push_back(name.get<std::string>());
    }
    if (entry.has("environment")) environment = entry.text("environment");
    if (entry.has("model")) model = entry.text("model");
    visit(entry.get("tree"));
    check_totals(entry);
  }

  std::vector<std::string> files;
  std::string environment, model;
  std::vector<Leaf> leaves;
  std::uint64_t nodes = 0, merged = 0;  // merged: Gaussians that no leaf names in its finest level

  std::size_t level_count() const { return totals_.size(); }

 private:
  const json& object(const json& value) const {
    if (!value.is_object()) fail("{}: not a tree of levels of detail", source_);
    return value;
  }

  std::uint64_t number(const json& level, const char* key) const {
    return JsonEntry{level, source_}.whole(level.value(key, json()), key);
  }

  // parse_json() limits the depth.
  void visit(const json& node) {
    ++nodes;
    const JsonEntry entry{object(node), source_};
    if (entry.has("children")) {
      if (!node["children"].is_array()) fail("{}: children is not a list", source_);
      for (const json& child : node["children"]) visit(child);
    }
    if (!entry.has("lods")) return;
    const json& levels = object(node["lods"]);
    if (levels.empty()) return;
    // The finest level has the lowest number. Keys are sorted as texts, so it is the first one of
    // the shortest keys.
    std::string lowest = levels.begin().key();
    for (const auto& [level, part] : levels.items()) {
      const std::uint64_t count = number(object(part), "count");
      totals_[level] += count;
      merged += count;
      if (level.size() < lowest.size()) lowest = level;
    }
    const json& finest = levels[lowest];
    leaves.push_back({number(finest, "file"), number(finest, "offset"), number(finest, "count")});
    merged -= leaves.back().count;
    if (leaves.back().file >= files.size())
      fail("{}: file {} is not in the list of files", source_, leaves.back().file);
  }

  // The description may state the Gaussians of each level and of all levels, without the
  // environment.
  void check_totals(const JsonEntry& entry) {
    std::uint64_t all = 0;
    for (const auto& [level, total] : totals_) all += total;
    if (entry.has("count") && number(root_, "count") != all)
      fail("{}: count is {}, but its tree has {} Gaussians", source_, number(root_, "count"), all);
    if (!entry.has("counts")) return;
    const json& counts = root_["counts"];
    if (!counts.is_array()) fail("{}: counts is not a list", source_);
    for (std::size_t i = 0; i < counts.size(); ++i) totals_.try_emplace(fmt::format("{}", i), 0);
    for (const auto& [level, total] : totals_) {
      const std::uint64_t stated = stated_count(counts, level);
      if (stated != total)
        fail("{}: counts has {} Gaussians in level {}, but its tree has {}", source_, stated, level,
             total);
    }
  }

  // 0 for a level that is not in the list.
  std::uint64_t stated_count(const json& counts, const std::string& level) const {
    for (std::size_t i = 0; i < counts.size(); ++i)
      if (level == fmt::format("{}", i)) return number({{"counts", counts[i]}}, "counts");
    return 0;
  }

  const std::string& source_;
  json root_;
  std::map<std::string, std::uint64_t> totals_;  // Gaussians of the tree, by level
};

}  // namespace

bool recognises_sog(ByteSpan content, const std::filesystem::path& path) {
  if (is_zip(content))
    return !is_npz(content) && !is_torch_archive(content) && !is_usdz(content) &&
           (path.extension() == ".sog" || !ply_in_zip(content));
  return json_kind(text_of(content).substr(0, kMaxMetaBytes)) == JsonKind::sog;
}

void read_sog(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
              const ReadOptions& options, Scene& scene) {
  const bool zipped = is_zip(content);
  const auto files = zipped ? files_in_zip(content, path, kMetaFile) : files_beside(path);
  Array<std::byte> unpacked;
  if (zipped) {
    unpacked = files->read(kMetaFile, kMaxMetaBytes);
    content = unpacked;
  }
  const std::string source = zipped ? path.string() + ": " + kMetaFile : path.string();
  if (content.size() > kMaxMetaBytes) fail("{}: too long for a SOG scene's description", source);
  SogDecoder decoder(text_of(content), source, *files, "", pool);
  options.progress.update(0.5f);
  if (!zipped) scene.file_bytes += decoder.picture_bytes();
  scene.format = fmt::format("sog, version {}{}", decoder.version(), zipped ? "" : ", folder");
  fill_from({{&decoder, 0, decoder.count()}}, scene, pool, options.progress);
  add_warnings(decoder, scene);
  apply_models({decoder.model().empty() ? "default" : decoder.model()}, scene);
}

bool recognises_streamed_sog(ByteSpan content, const std::filesystem::path&) {
  return json_kind(text_of(content).substr(0, kMaxTreeBytes)) == JsonKind::streamed_sog;
}

void read_streamed_sog(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                       const ReadOptions& options, Scene& scene) {
  const std::string source = path.string();
  if (content.size() > kMaxTreeBytes) fail("{}: too long for a tree of scenes", source);
  const Tree tree(text_of(content), source);
  const auto files = files_beside(path);
  std::map<std::string, std::unique_ptr<SogDecoder>> decoders;
  // Opens each SOG scene of the tree once, when it is first needed.
  const auto open = [&](const std::string& stored_name) -> SogDecoder& {
    const std::string name = checked_file_name(stored_name, source);
    std::unique_ptr<SogDecoder>& decoder = decoders[name];
    if (decoder) return *decoder;
    const auto meta = files->read(name, kMaxMetaBytes);
    const std::string folder = name.substr(0, name.rfind('/') + 1);  // empty without a slash
    decoder =
        std::make_unique<SogDecoder>(text_of(meta), source + ": " + name, *files, folder, pool);
    scene.file_bytes += meta.size() + decoder->picture_bytes();
    return *decoder;
  };
  std::vector<Part> parts;
  std::map<SogDecoder*, std::uint64_t> used;
  const auto add = [&](SogDecoder& decoder, std::uint64_t offset, std::uint64_t count) {
    if (offset > decoder.count() || count > decoder.count() - offset)
      fail("{}: a leaf names Gaussians {} to {} of a file with {}", source, offset, offset + count,
           decoder.count());
    if ((used[&decoder] += count) > decoder.count())
      fail("{}: its leaves name more Gaussians than their files have", source);
    if (count > 0) parts.push_back({&decoder, offset, count});
  };
  for (std::size_t i = 0; i < tree.leaves.size(); ++i) {
    const Leaf& leaf = tree.leaves[i];
    add(open(tree.files[leaf.file]), leaf.offset, leaf.count);
    options.progress.update(0.5f * static_cast<float>(i + 1) /
                            static_cast<float>(tree.leaves.size()));
  }
  if (!tree.environment.empty()) {
    SogDecoder& decoder = open(tree.environment);
    add(decoder, 0, decoder.count());
  }
  if (parts.empty()) fail("{}: holds no Gaussians", source);

  scene.format = "streamed sog, finest level";
  fill_from(parts, scene, pool, options.progress);
  std::uint64_t leaves = 0;
  for (const Part& part : parts) leaves += part.count;
  scene.levels = {tree.level_count(), tree.nodes, leaves, tree.merged};
  std::set<std::string> models;
  for (const auto& [name, decoder] : decoders) {
    add_warnings(*decoder, scene);
    const std::string& model = decoder->model().empty() ? tree.model : decoder->model();
    models.insert(model.empty() ? "default" : model);
  }
  apply_models(models, scene);
}

}  // namespace qs
