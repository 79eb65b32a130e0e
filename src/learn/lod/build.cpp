// SPDX-License-Identifier: MIT
#include "learn/lod/build.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <mutex>
#include <numeric>
#include <semaphore>
#include <span>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "base/path_kind.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "io/bytes/mapped_file.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/scene/instances.h"
#include "io/scene/ply/ply.h"
#include "io/scene/rad/rad_original.h"
#include "io/scene/reader.h"
#include "learn/lod/bucket_files.h"
#include "learn/lod/section.h"
#include "raster/scene/place.h"

namespace qs {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr float kRead = 0.1f, kSorted = 0.2f, kBuilt = 0.85f;  // of the progress
// Of memory while its bucket is worked on; original values are kept twice.
constexpr std::uint64_t kBytesOfLeaf = 1500, kBytesOfOriginal = 8 * original_words(3);
constexpr std::uint64_t kMostLeaves = 262'144;  // of a bucket
constexpr std::size_t kLeavesOfRoot = 256;

// The result of the first reading, which the journal keeps.
struct Survey {
  std::uint64_t leaves = 0, buckets = 0;
  int sh_degree = 0;
  float footprint = 1;  // the smallest one
  bool antialiased = false;
  glm::dvec3 origin{0.0};  // of the first part
};

// A scene file; or, if `end` is not 0, rows [begin, end) of a .ply or instances of a scene.
struct Part {
  fs::path path;
  std::uint64_t begin = 0, end = 0;
  std::shared_ptr<const InstanceFile> instances = {};
};

// Bytes for one bucket per thread: at least 4 GB, and above that at most half of the available
// memory.
std::uint64_t usual_memory(int threads, std::uint64_t bytes_of_leaf) {
  constexpr std::uint64_t kUsual = 4'000'000'000;
  return std::clamp(static_cast<std::uint64_t>(threads) * kMostLeaves * bytes_of_leaf, kUsual,
                    std::max(kUsual, available_memory() / 2));
}

class Builder {
 public:
  Builder(const LodBuild& build, ThreadPool& pool)
      : build_(build),
        pool_(pool),
        folder_(build.output.string() + ".unfinished"),
        bytes_of_leaf_(kBytesOfLeaf + (build.original ? kBytesOfOriginal : 0)),
        memory_(build.memory > 0 ? build.memory : usual_memory(pool.size(), bytes_of_leaf_)) {}

  LodReport run() {
    for (const fs::path& input : build_.inputs) inputs_.push_back(find_scene_file(input));
    check_targets({build_.output});
    make_folder(folder_);
    const FolderLock lock(folder_, "another program builds this file");
    divide_inputs();
    if (!go_on()) {
      survey();
      sort();
      write_text(journal(), json_file_text({{"job", job()},
                                            {"leaves", survey_.leaves},
                                            {"buckets", survey_.buckets},
                                            {"sh_degree", survey_.sh_degree},
                                            {"footprint", survey_.footprint},
                                            {"antialiased", survey_.antialiased},
                                            {"origin", format_origin(survey_.origin)}}));
    }
    make_sections();
    const LodReport report = write();
    std::error_code ignored;
    pool_.for_each(buckets(), 1, [&](std::size_t i) {
      std::error_code own;
      fs::remove(section(i), own);
    });
    fs::remove_all(folder_, ignored);
    return report;
  }

 private:
  fs::path journal() const { return folder_ / "journal.json"; }
  fs::path bucket(std::size_t i) const { return folder_ / fmt::format("bucket_{:06}", i); }
  fs::path section(std::size_t i) const { return folder_ / fmt::format("section_{:06}", i); }
  std::size_t buckets() const { return survey_.buckets; }
  std::uint64_t leaves_of_bucket() const {
    return std::clamp<std::uint64_t>(memory_ / (2 * bytes_of_leaf_), 1024, kMostLeaves);
  }
  // The number of buckets that fit into the memory.
  std::size_t buckets_at_a_time() const {
    return std::max<std::uint64_t>(1, memory_ / (leaves_of_bucket() * bytes_of_leaf_));
  }
  SectionOptions options() const { return {survey_.footprint, survey_.antialiased}; }

  // A bucket that was built by another job must not be used.
  ordered_json job() const {
    ordered_json files = ordered_json::array();
    for (const fs::path& path : inputs_) {
      std::error_code error;
      files.push_back({path.string(), fs::file_size(path, error),
                       fs::last_write_time(path, error).time_since_epoch().count()});
    }
    return {{"version", 4},
            {"inputs", files},
            {"axes", build_.axes},
            {"original", build_.original},
            {"leaves_of_bucket", leaves_of_bucket()}};
  }

  // True if the folder has the sorted buckets of this job. Deletes everything of another job.
  bool go_on() {
    if (is_file(journal())) try {
        const ordered_json json = parse_own_json(read_text_file(journal(), std::size_t{1} << 28));
        if (json.at("job") == job()) {
          survey_ = {json.at("leaves"),
                     json.at("buckets"),
                     json.at("sh_degree"),
                     json.at("footprint"),
                     json.at("antialiased"),
                     parse_origin(json.at("origin").get<std::string>()).value_or(survey_.origin)};
          build_.warn(
              fmt::format("{}: going on with the work of an earlier call", folder_.string()));
          return true;
        }
      } catch (const nlohmann::json::exception&) {
        // An unreadable journal belongs to another job.
      }
    for (const auto& entry : fs::directory_iterator(folder_)) fs::remove_all(entry.path());
    return false;
  }

  // Binary .ply files and instances are read in parts.
  void divide_inputs() {
    const std::uint64_t rows = std::clamp<std::uint64_t>(memory_ / 2000, 1024, 1 << 22);
    for (const fs::path& path : inputs_) {
      const MappedFile file(path);
      std::uint64_t all = divisible_rows(file.content(), path), step = rows;
      std::shared_ptr<const InstanceFile> instances;
      if (recognises_instances(file.content(), path)) {
        instances =
            std::make_shared<const InstanceFile>(open_instances(file.content(), path, pool_, {}));
        all = instances->instances.size();
        step = std::max<std::uint64_t>(1, rows / instances->one.cloud.size());
      }
      if (all <= step) parts_.push_back({path});
      for (std::uint64_t begin = 0; all > step && begin < all; begin += step)
        parts_.push_back({path, begin, std::min(all, begin + step), instances});
    }
  }

  Scene read_part(const Part& part, const ReadOptions& options) {
    if (part.end == 0) return read_scene(part.path, pool_, options);
    Scene scene;
    scene.path = part.path;
    if (part.instances) {
      fill_instances(*part.instances, part.begin, part.end, pool_, options.progress, scene);
    } else {
      const MappedFile file(part.path);
      const std::string rows = ply_part(file.content(), part.path, part.begin, part.end);
      read_ply(std::as_bytes(std::span(rows)), part.path, pool_, options, scene);
    }
    move_near_origin(scene.cloud);
    if (!options.axes.empty()) assume_axes(scene, options.axes);
    return scene;
  }

  // Reads a part of the inputs, or returns the only one again.
  const GaussianCloud& read(std::size_t i, float begin, float end, bool warns) {
    if (cloud_ && parts_.size() == 1) return *cloud_;
    cloud_.reset();
    const auto at = [&](std::size_t k) {
      return begin + (end - begin) * static_cast<float>(k) / static_cast<float>(parts_.size());
    };
    ReadOptions options;
    options.axes = build_.axes;
    options.progress = part_of(build_.progress, at(i), at(i + 1));
    Scene scene = read_part(parts_[i], options);
    if (warns)
      for (const std::string& sentence : scene.warnings)
        add_new(warnings_, fmt::format("{}: {}", parts_[i].path.string(), sentence));
    cloud_ = std::make_unique<GaussianCloud>(std::move(scene.cloud));
    if (i == 0 && warns) survey_.origin = cloud_->origin;
    place(*cloud_, survey_.origin);
    return *cloud_;
  }

  void survey() {
    CloudSample sample;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const GaussianCloud& cloud = read(i, 0, kRead, true);
      if (i == 0) survey_.antialiased = cloud.antialiased;
      if (cloud.antialiased != survey_.antialiased)
        add_new(warnings_,
                fmt::format("{}: was trained {} antialiasing, unlike the first scene, whose "
                            "setting holds for the tree",
                            parts_[i].path.string(), cloud.antialiased ? "with" : "without"));
      survey_.sh_degree = std::max(survey_.sh_degree, cloud.sh_degree);
      sample.add(cloud, survey_.leaves);
      survey_.leaves += cloud.size();
    }
    for (const std::string& sentence : warnings_) build_.warn(sentence);
    constexpr std::uint64_t kMostNodes = 0xffffffff / 2;
    if (survey_.leaves > kMostNodes)
      fail("{}: {} Gaussians, but a .rad file has at most {}", build_.output.string(),
           survey_.leaves, kMostNodes);
    ranges_ = sample.ranges((survey_.leaves + leaves_of_bucket() - 1) / leaves_of_bucket());
    survey_.buckets = ranges_.splits.size() + 1;
    survey_.footprint = sample.footprint();
  }

  void sort() {
    BucketWriter writer(ranges_, survey_.sh_degree, build_.original,
                        [&](std::size_t i) { return bucket(i); });
    std::uint64_t done = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const GaussianCloud& cloud = read(i, kRead, kSorted, false);
      writer.add(cloud, done, pool_);
      done += cloud.size();
    }
    writer.finish();
    cloud_.reset();
  }

  void make_sections() {
    std::counting_semaphore<> places(static_cast<std::ptrdiff_t>(buckets_at_a_time()));
    std::size_t done = 0;
    std::mutex mutex;
    build_.progress.update(kSorted);
    pool_.for_chunks(buckets(), 1, [&](std::size_t i, std::size_t, int worker) {
      if (!is_file(section(i))) {
        places.acquire();
        try {
          LodItems items = read_bucket(bucket(i), survey_.sh_degree, build_.original);
          const std::size_t roots = (items.size() + kLeavesOfRoot - 1) / kLeavesOfRoot;
          write_section(section(i), make_section(std::move(items), roots, options()));
        } catch (...) {
          places.release();
          throw;
        }
        places.release();
      }
      std::error_code ignored;
      fs::remove(bucket(i), ignored);
      const std::lock_guard lock(mutex);
      ++done;
      if (worker == 0)
        build_.progress.update(kSorted + (kBuilt - kSorted) * static_cast<float>(done) /
                                             static_cast<float>(buckets()));
    });
  }

  LodReport write() {
    LodItems all;
    std::vector<std::uint64_t> first_root(buckets() + 1), nodes_below(buckets());
    for (std::size_t b = 0; b < buckets(); ++b) {
      const LodSection part = read_section(section(b), true);
      first_root[b + 1] = first_root[b] + part.roots.size();
      all.append(part.roots);
    }
    const std::uint64_t roots = all.size();
    for (std::size_t b = 0; b < buckets(); ++b)
      nodes_below[b] = section_nodes(section(b)) - (first_root[b + 1] - first_root[b]);
    LodSection upper = make_section(std::move(all), 1, options());
    std::vector<std::uint32_t> place(roots);  // of a bucket's root in the file
    for (std::uint32_t i = 0; i < upper.items.size(); ++i)
      if (upper.items[i] != ~0u) place[upper.items[i]] = i;
    LodReport report{survey_.leaves, upper.tree.nodes.size(), buckets(), survey_.sh_degree,
                     survey_.origin};
    std::vector<std::uint64_t> base(buckets());  // of the nodes below the roots
    for (std::size_t b = 0; b < buckets(); ++b) {
      base[b] = report.nodes;
      report.nodes += nodes_below[b];
      for (std::uint64_t r = first_root[b]; r < first_root[b + 1]; ++r)
        if (LodNode& root = upper.tree.nodes[place[r]]; root.child_count > 0)
          root.first_child = static_cast<std::uint32_t>(
              root.first_child - (first_root[b + 1] - first_root[b]) + base[b]);
    }
    replace_file(build_.output, [&](const fs::path& temporary) {
      std::ofstream stream(temporary, std::ios::binary);
      RadWriter writer(stream,
                       {report.nodes, survey_.sh_degree, survey_.footprint, survey_.antialiased,
                        build_.original, survey_.origin},
                       pool_);
      std::uint64_t leaves = 0;
      std::vector<RadNodes> parts;  // of the file, that are not written yet
      parts.push_back(std::move(upper.tree));
      for (std::size_t b = 0; b < buckets();) {
        const std::size_t first = parts.size();
        const std::size_t count =
            std::min({buckets() - b, buckets_at_a_time(), static_cast<std::size_t>(pool_.size())});
        parts.resize(first + count);
        std::vector<std::uint64_t> leaves_of(count);
        pool_.for_each(count, 1, [&](std::size_t i) {
          const std::uint64_t roots_before = first_root[b + i];
          parts[first + i] = placed_section(
              b + i, std::span(place).subspan(roots_before, first_root[b + i + 1] - roots_before),
              base[b + i], leaves_of[i]);
        });
        leaves = std::accumulate(leaves_of.begin(), leaves_of.end(), leaves);
        b += count;
        write_chunks(writer, parts, b == buckets());
        if (!stream) fail_to_write(build_.output, temporary);
        build_.progress.update(kBuilt + (1 - kBuilt) * static_cast<float>(b) /
                                            static_cast<float>(buckets()));
      }
      // The computer may have lost its power while they were written.
      if (leaves != survey_.leaves)
        fail("{}: damaged: {} of {} Gaussians are left; delete this folder and try again",
             folder_.string(), leaves, survey_.leaves);
      writer.finish();
      stream.close();
      if (!stream) fail_to_write(build_.output, temporary);
    });
    return report;
  }

  // The nodes of a bucket below its roots. `roots`: the places of the roots in the file; `base`:
  // the place of the first node. Counts the leaves, roots too.
  RadNodes placed_section(std::size_t b, std::span<const std::uint32_t> roots, std::uint64_t base,
                          std::uint64_t& leaves) const {
    RadNodes tree = read_section(section(b), false).tree, below;
    for (LodNode& node : tree.nodes) {
      leaves += node.child_count == 0 ? 1 : 0;
      if (node.child_count > 0)
        node.first_child = static_cast<std::uint32_t>(node.first_child - roots.size() + base);
      node.parent = node.parent < roots.size()
                        ? roots[node.parent]
                        : static_cast<std::uint32_t>(node.parent - roots.size() + base);
    }
    below.append(tree, roots.size(), tree.nodes.size());
    return below;
  }

  // Writes all full chunks of the parts, or everything at the end, and keeps the rest.
  void write_chunks(RadWriter& writer, std::vector<RadNodes>& parts, bool is_last) {
    std::vector<std::size_t> ends;
    std::size_t all = 0;
    for (const RadNodes& part : parts) ends.push_back(all += part.nodes.size());
    const std::size_t full = all / RadWriter::kChunk, rest = all % RadWriter::kChunk;
    std::vector<RadNodes> chunks(full + (rest > 0 ? 1 : 0));
    pool_.for_each(chunks.size(), 1, [&](std::size_t i) {
      std::size_t begin = i * RadWriter::kChunk;
      const std::size_t end = std::min(all, begin + RadWriter::kChunk);
      for (auto p = static_cast<std::size_t>(std::ranges::upper_bound(ends, begin) - ends.begin());
           begin < end; begin = ends[p++]) {
        const std::size_t start = ends[p] - parts[p].nodes.size();
        chunks[i].append(parts[p], begin - start, std::min(end, ends[p]) - start);
      }
    });
    parts.clear();
    if (rest > 0 && !is_last) {
      parts.push_back(std::move(chunks.back()));
      chunks.pop_back();
    }
    writer.write(chunks);
  }

  const LodBuild& build_;
  ThreadPool& pool_;
  fs::path folder_;
  std::uint64_t bytes_of_leaf_, memory_;
  std::vector<fs::path> inputs_;
  std::vector<Part> parts_;
  std::vector<std::string> warnings_;
  std::unique_ptr<GaussianCloud> cloud_;
  Survey survey_;
  BucketRanges ranges_;  // for sorting
};

}  // namespace

LodReport build_lod(const LodBuild& build, ThreadPool& pool) { return Builder(build, pool).run(); }

}  // namespace qs
