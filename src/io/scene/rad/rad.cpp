// SPDX-License-Identifier: MIT
#include "io/scene/rad/rad.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "io/bytes/file_source.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/cloud/linear_values.h"
#include "io/cloud/lod_tree.h"
#include "io/cloud/quantised.h"
#include "io/scene/rad/rad_chunk.h"
#include "raster/kernel/constants.h"

namespace qs {
namespace {

constexpr std::string_view kFileMagic = "RAD0";

// An octahedral axis, bytes for -1..1, and an angle, a byte for 0..pi.
glm::quat rotation_of_octahedron(float u, float v, float angle) {
  double x = u / 127.5 - 1, y = v / 127.5 - 1;
  const double z = 1 - std::abs(x) - std::abs(y);
  const double fold = std::max(-z, 0.0);
  x += x >= 0 ? -fold : fold;
  y += y >= 0 ? -fold : fold;
  const double half = angle / 255.0 * std::numbers::pi / 2;
  const double factor = std::sin(half) / std::sqrt(x * x + y * y + z * z);
  return make_quat(std::cos(half), x * factor, y * factor, z * factor);
}

// Stores the SH of a degree; the channel is the fastest index of value(i).
template <class Value>
void put_band(std::size_t degree, glm::vec3* sh, const Value& value) {
  for (std::size_t i = 0; i < 3 * (2 * degree + 1); ++i)
    sh[degree * degree + i / 3][static_cast<int>(i % 3)] = value(i);
}

class RadFile {
 public:
  RadFile(ByteSpan content, const std::filesystem::path& path, bool keeps_nodes, Scene& scene)
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
    if (has_tree_) read_tree(keeps_nodes && !is_part_ ? &scene.parents : nullptr);
    reads_all_ = !has_tree_ || !scene.parents.empty();
    for (std::size_t band = 0; band < 3; ++band) {
      const auto& table = chunks_[0].properties[kRadCodes + band];
      if (!table) continue;
      codes_[band] = rad_values(chunks_[0], kRadCodes + band);
      code_rows_ = table->rows;
    }
  }

  // The Gaussians that are read: the leaves, or all nodes.
  std::size_t read_count() const { return reads_all_ ? count_ : tree_.leaves.size(); }
  std::size_t chunk_count() const { return chunks_.size(); }

  RadLevels levels() const {
    if (is_part_ || !has_tree_ || !(footprint_ > 0 && footprint_ < 1e30))
      fail("{}: quadsplat lod did not write it: it has no errors", path_);
    RadLevels levels{{}, static_cast<float>(footprint_)};
    for (const RadChunk& chunk : chunks_)
      std::ranges::copy(rad_own_values(chunk), std::back_inserter(levels.nodes));
    for (std::size_t i = 0; i < levels.nodes.size(); ++i) {
      const LodNode& node = levels.nodes[i];
      for (std::uint64_t child = node.first_child;
           child < node.first_child + std::uint64_t{node.child_count}; ++child)
        if (levels.nodes[child].parent != i)
          fail("{}: node {} names node {} as its parent, but is a child of node {}", path_, child,
               levels.nodes[child].parent, i);
    }
    return levels;
  }

  int sh_degree() const {
    std::size_t degree = 0;
    for (const RadChunk& chunk : chunks_)
      for (std::size_t band = 0; band < 3; ++band)
        if (chunk.properties[kRadSh + band] || chunk.properties[kRadCodes + band])
          degree = std::max(degree, band + 1);
    return static_cast<int>(degree);
  }

  // Fills the Gaussians of one chunk. May be called from several threads for different chunks.
  void fill(std::size_t number, GaussianCloud& cloud, LinearValues& linear) {
    const RadChunk& chunk = chunks_[number];
    const std::size_t begin = read_before(chunk.base);
    const std::size_t end = read_before(chunk.base + chunk.count);
    // Calls use(k, row) for Gaussian k of the cloud and its row of the chunk.
    const auto for_read = [&](const auto& use) {
      for (std::size_t k = begin; k < end; ++k)
        use(k, static_cast<std::size_t>((reads_all_ ? k : tree_.leaves[k]) - chunk.base));
    };
    // Calls use(k, v) for Gaussian k and its values v(0), v(1) ... of a property.
    const auto fill_from = [&](std::size_t kind, const auto& use) {
      const std::vector<float> values = rad_values(chunk, kind);
      for_read([&](std::size_t k, std::size_t row) {
        use(k, [&](std::size_t i) { return values[i * chunk.count + row]; });
      });
    };
    fill_from(kRadCenter, [&](std::size_t k, const auto& v) {
      cloud.positions[k] = {v(0), v(1), v(2)};
    });
    fill_from(kRadAlpha, [&](std::size_t k, const auto& v) {
      cloud.opacity_logits[k] = linear.logit(static_cast<double>(v(0)));
    });
    const bool are_logarithms = chunk.get(kRadScales).coding != RadCoding::f32;
    fill_from(kRadScales, [&](std::size_t k, const auto& v) {
      const glm::vec3 scale(v(0), v(1), v(2));
      cloud.log_scales[k] = are_logarithms ? scale : linear.log_scale(scale);
    });
    const bool is_octahedral = chunk.get(kRadOrientation).coding == RadCoding::oct88r8;
    fill_from(kRadOrientation, [&](std::size_t k, const auto& v) {
      const auto q = restore_largest({v(0), v(1), v(2)}, 3);
      cloud.rotations[k] = is_octahedral ? rotation_of_octahedron(v(0), v(1), v(2))
                                         : make_quat(q[3], q[0], q[1], q[2]);
    });
    fill_from(kRadRgb, [&](std::size_t k, const auto& v) {
      glm::vec3* const sh = sh_of(cloud, k);
      std::fill_n(sh, sh_count(cloud), glm::vec3(0));
      sh[0] = (glm::dvec3(v(0), v(1), v(2)) - 0.5) / static_cast<double>(kSh0);
    });
    for (std::size_t degree = 1; degree <= 3; ++degree) {
      if (!chunk.properties[kRadSh + degree - 1]) continue;
      fill_from(kRadSh + degree - 1,
                [&](std::size_t k, const auto& v) { put_band(degree, sh_of(cloud, k), v); });
    }
    if (!chunk.properties[kRadLabel]) return;
    const std::vector<std::uint32_t> labels = rad_integers(chunk, kRadLabel);
    for_read([&](std::size_t k, std::size_t row) {
      const std::size_t label = labels[row];
      unlabelled_ += label >= code_rows_ ? 1 : 0;
      for (std::size_t degree = 1; label < code_rows_ && degree <= 3; ++degree) {
        const std::vector<float>& codes = codes_[degree - 1];
        if (!codes.empty())
          put_band(degree, sh_of(cloud, k),
                   [&](std::size_t i) { return codes[i * code_rows_ + label]; });
      }
    });
  }

  void describe(Scene& scene) const {
    scene.format = is_part_ ? "rad, one chunk" : has_tree_ ? "rad" : "rad, without levels";
    if (is_part_)
      scene.warn("A part of a .rad file: {} leaves of {} nodes were read.", read_count(), count_);
    else if (has_tree_)
      scene.levels = {tree_.levels, count_, tree_.leaves.size(), count_ - tree_.leaves.size(),
                      footprint_ > 0};
    if (!scene.parents.empty() && scene.cloud.size() != count_)
      fail("{}: {} nodes of its tree cannot be drawn", path_, count_ - scene.cloud.size());
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
    if (reads_all_) return node;
    return static_cast<std::size_t>(std::ranges::lower_bound(tree_.leaves, node) -
                                    tree_.leaves.begin());
  }

  void read_chunks(ByteSpan content, const std::filesystem::path& path, Scene& scene) {
    ByteCursor cursor(content, path_);
    const nlohmann::json description = read_rad_description(cursor, kFileMagic, path_);
    const JsonEntry entry{description, path_};
    if (entry.has("type") && entry.text("type") != "gsplat")
      fail("{}: the type '{}' is not known", path_, printable(entry.text("type")));
    count_ = entry.whole("count");
    const std::uint64_t size = entry.has("chunkSize") ? entry.whole("chunkSize") : count_;
    const nlohmann::json& list = rad_list(entry, "chunks");
    if (count_ == 0) return;
    if (size == 0 || count_ >> 32 != 0 || list.size() != (count_ + size - 1) / size)
      fail("{}: {} nodes in {} chunks of {}", path_, count_, list.size(), size);
    has_tree_ = entry.has("lodTree") && entry.get("lodTree") == true;
    if (entry.has("quadsplat")) {
      const JsonEntry own{entry.get("quadsplat"), path_ + ": quadsplat"};
      footprint_ = own.number("footprint");
      scene.cloud.antialiased = own.has("antialiased") && own.get("antialiased") == true;
    }
    std::optional<std::uint64_t> codes;
    if (entry.has("shCodeCount")) codes = entry.whole("shCodeCount");
    const ByteSpan body = cursor.take(cursor.left(), "the chunks");
    const auto files = files_beside(path);
    std::uint64_t used = 0;
    for (std::uint64_t i = 0; i < list.size(); ++i) {
      const std::string source = fmt::format("{}: chunk {}", path_, i);
      const JsonEntry range{list[i], source};
      const std::uint64_t offset = range.whole("offset"), bytes = range.whole("bytes");
      Array<std::byte> loaded;
      if (range.has("filename")) {
        loaded = files->read(range.text("filename"), bytes);
        scene.file_bytes += loaded.size();
      } else {
        if (offset > body.size() || bytes > body.size() - offset)
          fail("{}: cut off: {} bytes at offset {} of {}", source, bytes, offset, body.size());
        used = std::max(used, offset + bytes);
      }
      RadChunk chunk = parse_rad_chunk(
          range.has("filename") ? ByteSpan(loaded) : body.subspan(offset, bytes), source, codes);
      const std::uint64_t base = i * size, expected = std::min(size, count_ - base);
      if (chunk.base != base || chunk.count != expected)
        fail("{}: holds {} nodes from node {} on, but must hold {} from node {} on", source,
             chunk.count, chunk.base, expected, base);
      chunk.loaded = std::move(loaded);  // its place in memory stays
      chunks_.push_back(std::move(chunk));
    }
    ignored_bytes_ = body.size() - used;
  }

  // Sets `parents`, if it is given.
  void read_tree(std::vector<std::uint32_t>* parents) {
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
      if (parents == nullptr) return;
      parents->assign(counts.size(), kNoParent);
      for (std::size_t i = 0; i < counts.size(); ++i)
        for (std::uint32_t child = 0; child < counts[i]; ++child)
          (*parents)[starts[i] + child] = static_cast<std::uint32_t>(i);
      return;
    }
    // The tree of a chunk alone lies in other chunks too.
    for (std::size_t i = 0; i < counts.size(); ++i)
      if (counts[i] == 0) tree_.leaves.push_back(static_cast<std::uint32_t>(i));
    if (tree_.leaves.empty()) fail("{}: this chunk of a .rad file has no leaves", path_);
  }

  std::string path_;
  bool is_part_, has_tree_ = false, reads_all_ = false;
  std::vector<RadChunk> chunks_;
  std::uint64_t count_ = 0, ignored_bytes_ = 0;
  LodTree tree_;
  std::array<std::vector<float>, 3> codes_;  // of SH, by band
  std::size_t code_rows_ = 0;
  std::atomic<std::size_t> unlabelled_ = 0;
  double footprint_ = 0;  // 0: quadsplat did not write the file
};

void fill_leaves(RadFile& file, ThreadPool& pool, const ReadOptions& options, Scene& scene) {
  constexpr float kDecoded = 0.9f;  // share of the progress
  const bool antialiased = scene.cloud.antialiased;
  scene.cloud = make_cloud(file.read_count(), file.sh_degree());
  scene.cloud.antialiased = antialiased;
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
  return text.starts_with(kFileMagic) || text.starts_with(kRadChunkMagic);
}

void read_rad(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
              const ReadOptions& options, Scene& scene) {
  RadFile file(content, path, options.keeps_nodes, scene);
  fill_leaves(file, pool, options, scene);
}

RadLevels read_rad_levels(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                          Scene& scene) {
  RadFile file(content, path, true, scene);
  RadLevels levels = file.levels();
  fill_leaves(file, pool, {}, scene);
  return levels;
}

}  // namespace qs
