// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "base/progress_bar.h"
#include "io/bytes/json_text.h"
#include "io/bytes/replace_file.h"
#include "io/scene/sog/sog.h"
#include "raster/scene/cloud_order.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostInFile = 524'288, kMostInWideLeaf = 8192;
constexpr float kWide = 16;  // world units

// Divides the levels into the leaves of the tree.
class LeafDivider {
 public:
  using Members = std::vector<std::uint32_t>;

  explicit LeafDivider(std::span<const SogLevel> levels) : levels_(levels) {}

  struct File {
    std::size_t level;
    Members members;
    std::string folder;
  };
  std::vector<File> files;

  ordered_json all() {
    std::vector<Members> members(levels_.size());
    for (std::size_t k = 0; k < levels_.size(); ++k) {
      members[k].resize(levels_[k].centers.size());
      std::iota(members[k].begin(), members[k].end(), 0u);
    }
    return node(std::move(members));
  }

 private:
  // The subtree of these Gaussians of each level.
  ordered_json node(std::vector<Members> members) {
    glm::vec3 low(INFINITY), high(-INFINITY);
    for (std::size_t k = 0; k < levels_.size(); ++k)
      for (const std::uint32_t i : members[k]) {
        const SogLevel& level = levels_[k];
        low = glm::min(low, level.centers[i] - level.sigmas[i]);
        high = glm::max(high, level.centers[i] + level.sigmas[i]);
      }
    const auto list = [](glm::vec3 v) { return ordered_json{v.x, v.y, v.z}; };
    ordered_json tree = {{"bound", {{"min", list(low)}, {"max", list(high)}}}};
    const glm::vec3 extent = high - low;
    const int axis = extent.x >= std::max(extent.y, extent.z) ? 0 : extent.y >= extent.z ? 1 : 2;
    Members& finest = members[0];
    const bool is_large =
        std::ranges::any_of(members, [](const Members& m) { return m.size() > kMostInFile; }) ||
        (extent[axis] > kWide && finest.size() > kMostInWideLeaf);
    if (!is_large || finest.size() < 2) {
      for (std::size_t k = 0; k < levels_.size(); ++k)
        tree["lods"][std::to_string(k)] = part(k, members[k]);
      return tree;
    }
    const auto at = [&](std::size_t k, std::uint32_t i) { return levels_[k].centers[i][axis]; };
    const auto middle = finest.begin() + static_cast<std::ptrdiff_t>(finest.size() / 2);
    std::ranges::nth_element(finest, middle, {}, [&](std::uint32_t i) {
      return std::pair(at(0, i), i);  // so that equal ones have an order
    });
    const float border = at(0, *middle);
    std::vector<Members> above(levels_.size());
    for (std::size_t k = 0; k < levels_.size(); ++k) {
      const auto first =
          k == 0 ? middle
                 : std::stable_partition(members[k].begin(), members[k].end(),
                                         [&](std::uint32_t i) { return at(k, i) < border; });
      above[k].assign(first, members[k].end());
      members[k].erase(first, members[k].end());
    }
    tree["children"] = {node(std::move(members)), node(std::move(above))};
    return tree;
  }

  // Puts a leaf's Gaussians of a level into a file, along a Morton curve.
  ordered_json part(std::size_t level, const Members& members) {
    auto file = std::ranges::find_if(files, [&](const File& f) {
      return f.level == level && f.members.size() + members.size() <= kMostInFile;
    });
    if (file == files.end()) {
      const auto number = std::ranges::count(files, level, &File::level);
      file = files.insert(file, {level, {}, fmt::format("{}_{}", level, number)});
    }
    const ordered_json place = {{"file", file - files.begin()},
                                {"offset", file->members.size()},
                                {"count", members.size()}};
    GaussianCloud centers;  // without the rest
    for (const std::uint32_t i : members) centers.positions.push_back(levels_[level].centers[i]);
    for (const std::uint32_t i : morton_order(centers)) file->members.push_back(members[i]);
    return place;
  }

  std::span<const SogLevel> levels_;
};

}  // namespace

void write_streamed_sog(std::span<const SogLevel> levels, const std::filesystem::path& folder,
                        ThreadPool& pool, const Progress& progress) {
  LeafDivider divider(levels);
  const ordered_json tree = divider.all();
  std::size_t count = 0;
  ordered_json counts, names;
  for (const SogLevel& level : levels)
    count += counts.emplace_back(level.centers.size()).get<std::size_t>();
  for (const auto& file : divider.files) names.push_back(file.folder + "/meta.json");
  ordered_json description = {{"version", 1},       {"count", count},
                              {"counts", counts},   {"lodLevels", levels.size()},
                              {"filenames", names}, {"tree", tree}};
  const auto& files = divider.files;
  // Pictures of so many files that every thread has some to encode.
  const auto at_once = static_cast<std::size_t>(pool.size());
  replace_folder(folder, [&](const std::filesystem::path& hidden) {
    for (std::size_t first = 0; first < files.size(); first += at_once) {
      const std::size_t end = std::min(files.size(), first + at_once);
      const Progress batch =
          step_of(progress, first / at_once, (files.size() + at_once - 1) / at_once);
      std::vector<SogPictures> scenes;
      for (std::size_t i = first; i < end; ++i) {
        const GaussianCloud cloud = levels[files[i].level].gaussians(files[i].members);
        if (cloud.antialiased) description["model"] = "antialiased";
        scenes.push_back(
            sog_pictures(cloud, pool, step_of(part_of(batch, 0, 0.6f), i - first, end - first)));
      }
      const auto encoded = encode_pictures(scenes, pool, progress.stop);
      for (std::size_t i = 0; i < encoded.size(); ++i) {
        const std::filesystem::path place = hidden / files[first + i].folder;
        make_folder(place);
        for (const ZipEntry& entry : encoded[i]) write_text(place / entry.name, entry.content);
      }
      batch.update(1);
    }
    write_text(hidden / "lod-meta.json", json_line(description));
  });
}

}  // namespace qs
