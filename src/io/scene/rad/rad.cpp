// SPDX-License-Identifier: MIT
#include "io/scene/rad/rad.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "io/bytes/file_source.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/cloud/lod_tree.h"
#include "io/scene/rad/rad_file.h"
#include "io/scene/rad/rad_original.h"

namespace qs {
namespace {

class RadFile {
 public:
  RadFile(ByteSpan content, const std::filesystem::path& path, Scene& scene)
      : path_(path.string()), is_part_(text_of(content).starts_with(kRadChunkMagic)) {
    if (is_part_) {
      chunks_.push_back(parse_rad_chunk(content, path_, {}));
      chunks_[0].base = 0;
      count_ = chunks_[0].count;
    } else {
      read_chunks(content, path, scene);
    }
    if (count_ == 0) fail("{}: holds no Gaussians", path_);
    has_tree_ = has_tree_ || chunks_[0].properties[kRadChildCount];
    tree_.leaves.resize(has_tree_ ? 0 : count_);
    std::iota(tree_.leaves.begin(), tree_.leaves.end(), 0u);
    if (has_tree_) read_tree();
    codes_.emplace(chunks_[0]);
    if (header_.has_originals && has_tree_) taken_ = decltype(taken_)(read_count());
  }

  std::size_t read_count() const { return tree_.leaves.size(); }
  std::size_t chunk_count() const { return chunks_.size(); }

  int sh_degree() const {
    int degree = 0;
    for (const RadChunk& chunk : chunks_) degree = std::max(degree, chunk.sh_degree());
    return degree;
  }

  // Fills the Gaussians of one chunk. May be called from several threads for different chunks.
  void fill(std::size_t number, GaussianCloud& cloud, LinearValues& linear) {
    const RadChunk& chunk = chunks_[number];
    const std::size_t begin = read_before(chunk.base);
    std::vector<std::uint32_t> rows(read_before(chunk.base + chunk.count) - begin);
    for (std::size_t k = 0; k < rows.size(); ++k)
      rows[k] = static_cast<std::uint32_t>(tree_.leaves[begin + k] - chunk.base);
    const RadOriginals originals(chunk);
    std::vector<std::uint32_t> places(rows.size());
    std::iota(places.begin(), places.end(), static_cast<std::uint32_t>(begin));
    if (!taken_.empty() && !rows.empty()) {
      const std::vector<std::uint32_t> numbers = originals.numbers();
      for (std::size_t k = 0; k < rows.size(); ++k) {
        places[k] = numbers[rows[k]];
        if (places[k] >= taken_.size() || taken_[places[k]].exchange(true))
          fail("{}: node {} is leaf {} of {}, or another leaf is it", chunk.source,
               chunk.base + rows[k], places[k], taken_.size());
      }
    }
    unlabelled_ += fill_gaussians(chunk, *codes_, rows, places, cloud, linear);
    originals.restore(rows, places, cloud);
  }

  void describe(Scene& scene) const {
    scene.format = is_part_ ? "rad, one chunk" : has_tree_ ? "rad" : "rad, without levels";
    if (is_part_)
      scene.warn("A part of a .rad file: {} leaves of {} nodes were read.", read_count(), count_);
    else if (has_tree_)
      scene.levels = {tree_.levels,          count_,
                      tree_.leaves.size(),   count_ - tree_.leaves.size(),
                      header_.footprint > 0, header_.has_originals};
    std::uint64_t ignored = ignored_bytes_;
    for (const RadChunk& chunk : chunks_) {
      ignored += chunk.ignored_bytes;
      for (const std::string& name : chunk.unknown)
        add_new(scene.warnings,
                fmt::format("The property '{}' is not known and was ignored.", name));
    }
    if (ignored > 0)
      scene.warn("{} bytes after the properties of its chunks were ignored.", ignored);
    if (unlabelled_ > 0) warn_of_missing_sh(scene, unlabelled_);
  }

 private:
  std::size_t read_before(std::uint64_t node) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(tree_.leaves, node) -
                                    tree_.leaves.begin());
  }

  void read_chunks(ByteSpan content, const std::filesystem::path& path, Scene& scene) {
    ByteCursor cursor(content, path_);
    header_ = read_rad_header(cursor, path_);
    count_ = header_.count;
    has_tree_ = header_.has_tree;
    scene.cloud.antialiased = header_.antialiased;
    scene.cloud.origin = header_.origin;
    const ByteSpan body = cursor.take(cursor.left(), "the chunks");
    const auto files = files_beside(path);
    std::uint64_t used = 0;
    for (std::uint64_t i = 0; i < header_.chunks.size(); ++i) {
      const auto& [offset, bytes, file] = header_.chunks[i];
      Array<std::byte> loaded;
      if (file) {
        loaded = files->read(*file, bytes);
        scene.file_bytes += loaded.size();
      } else {
        header_.require_inside(i, body.size(), path_);
        used = std::max(used, offset + bytes);
      }
      RadChunk chunk =
          header_.chunk(i, !file ? body.subspan(offset, bytes) : ByteSpan(loaded), path_);
      chunk.loaded = std::move(loaded);  // its place in memory stays
      chunks_.push_back(std::move(chunk));
    }
    ignored_bytes_ = body.size() - used;
  }

  void read_tree() {
    const auto all = [&](RadKind kind) {
      std::vector<std::uint32_t> values;
      for (const RadChunk& chunk : chunks_)
        std::ranges::copy(rad_integers(chunk, kind), std::back_inserter(values));
      return values;
    };
    const auto counts = all(kRadChildCount), starts = all(kRadChildStart);
    if (!is_part_) {
      const auto children_of = [&](std::size_t i) { return LodChildren{starts[i], counts[i]}; };
      tree_ = read_lod_tree(counts.size(), children_of, path_);
      return;
    }
    // The tree of a chunk alone lies in other chunks too.
    for (std::size_t i = 0; i < counts.size(); ++i)
      if (counts[i] == 0) tree_.leaves.push_back(static_cast<std::uint32_t>(i));
    if (tree_.leaves.empty()) fail("{}: this chunk of a .rad file has no leaves", path_);
  }

  std::string path_;
  bool is_part_, has_tree_ = false;
  RadHeader header_;
  std::vector<RadChunk> chunks_;
  std::uint64_t count_ = 0, ignored_bytes_ = 0;
  LodTree tree_;  // its leaves are read: all nodes of a file without a tree
  std::optional<RadCodes> codes_;
  std::atomic<std::size_t> unlabelled_ = 0;
  std::vector<std::atomic<bool>> taken_;  // places of original leaves; empty: the file's order
};

void fill_leaves(RadFile& file, ThreadPool& pool, const ReadOptions& options, Scene& scene) {
  constexpr float kDecoded = 0.9f;  // share of the progress
  GaussianCloud cloud = make_cloud(file.read_count(), file.sh_degree());
  cloud.antialiased = scene.cloud.antialiased;
  cloud.origin = scene.cloud.origin;
  scene.cloud = std::move(cloud);
  LinearValues linear;
  pool.for_chunks(file.chunk_count(), 1, [&](std::size_t chunk, std::size_t, int worker) {
    if (worker == 0)
      options.progress.update(kDecoded * static_cast<float>(chunk) /
                              static_cast<float>(file.chunk_count()));
    file.fill(chunk, scene.cloud, linear);
  });
  fill_cloud(scene, pool, options.progress, kDecoded, [](std::size_t, std::size_t) {});
  linear.warn(scene);
  file.describe(scene);
}

}  // namespace

bool recognises_rad(ByteSpan content, const std::filesystem::path&) {
  const std::string_view text = text_of(content);
  return text.starts_with(kRadFileMagic) || text.starts_with(kRadChunkMagic);
}

void read_rad(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
              const ReadOptions& options, Scene& scene) {
  RadFile file(content, path, scene);
  fill_leaves(file, pool, options, scene);
}

}  // namespace qs
