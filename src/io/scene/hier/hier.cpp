// SPDX-License-Identifier: MIT
#include "io/scene/hier/hier.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/gtc/packing.hpp>

#include "io/bytes/byte_cursor.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/cloud/linear_values.h"
#include "io/cloud/lod_tree.h"

namespace qs {
namespace {

constexpr std::uint64_t kShValues = 48;

// Bytes of a number, a node and its box. Positions are floats in both layouts.
struct Layout {
  std::uint64_t number, node, box;
};
constexpr Layout kFloats{4, 28, 32}, kHalves{2, 20, 16};

struct Node {
  std::int64_t start, leaves, merged;  // its Gaussians: leaves, then merged Gaussians
  std::int64_t first_child, children;
};

Node parse_node(const std::byte* at, bool halves) {
  const auto integer = [&](int i) -> std::int64_t { return load<std::int32_t>(at + 4 * i); };
  const auto small = [&](int i) -> std::int64_t { return load<std::int16_t>(at + 12 + 2 * i); };
  // Integers are parent, start, first child, and 16-bit ones depth, children, leaves, merged; or
  // depth, parent, start, leaves, merged, first child, children.
  if (halves) return {integer(1), small(2), small(3), integer(2), small(1)};
  return {integer(2), integer(3), integer(4), integer(5), integer(6)};
}

class HierFile {
 public:
  HierFile(ByteSpan content, std::string path) : path_(std::move(path)), cursor_(content, path_) {
    const std::int64_t stored = cursor_.read<std::int32_t>("the number of Gaussians");
    halves_ = stored < 0;
    layout_ = halves_ ? kHalves : kFloats;
    count_ = static_cast<std::uint64_t>(halves_ ? -stored : stored);
    if (count_ == 0) fail("{}: holds no Gaussians", path_);
    positions_ = cursor_.take(3 * sizeof(float) * count_, "the block of positions");
    rotations_ = cursor_.take(4 * layout_.number * count_, "the block of rotations");
    scales_ = cursor_.take(3 * layout_.number * count_, "the block of scales");
    alphas_ = cursor_.take(layout_.number * count_, "the block of opacities");
    sh_ = cursor_.take(kShValues * layout_.number * count_, "the block of SH");
    const auto nodes = cursor_.read<std::int32_t>("the number of nodes");
    if (nodes <= 0) fail("{}: its tree has {} nodes", path_, nodes);
    node_count_ = static_cast<std::uint64_t>(nodes);
    nodes_ = cursor_.take(layout_.node * node_count_, "the tree");
    cursor_.take(layout_.box * node_count_, "the block of boxes");
    std::vector<bool> named(count_);
    const auto children_of = [&](std::uint64_t i) { return take_node(i, named); };
    levels_ = read_lod_tree(node_count_, children_of, path_).levels;
    if (leaves_.empty()) fail("{}: its tree has no leaves", path_);
    std::ranges::sort(leaves_);
  }

  const std::vector<std::uint32_t>& leaves() const { return leaves_; }

  // Fills Gaussian k with leaf k.
  void fill(GaussianCloud& cloud, std::size_t k, LinearValues& linear) const {
    const std::uint64_t row = leaves_[k];
    const auto number = [&](ByteSpan block, std::uint64_t size, std::uint64_t i) {
      const std::byte* const at = block.data() + (row * size + i) * layout_.number;
      return halves_ ? glm::unpackHalf1x16(load<std::uint16_t>(at)) : load<float>(at);
    };
    cloud.positions[k] = load<glm::vec3>(positions_.data() + row * sizeof(glm::vec3));
    cloud.rotations[k] = glm::quat(number(rotations_, 4, 0), number(rotations_, 4, 1),
                                   number(rotations_, 4, 2), number(rotations_, 4, 3));
    cloud.log_scales[k] = {number(scales_, 3, 0), number(scales_, 3, 1), number(scales_, 3, 2)};
    cloud.opacity_logits[k] = linear.logit(static_cast<double>(number(alphas_, 1, 0)));
    glm::vec3* const sh = sh_of(cloud, k);
    for (std::uint64_t i = 0; i < kShValues; ++i)
      sh[i / 3][static_cast<int>(i % 3)] = number(sh_, kShValues, i);
  }

  void describe(Scene& scene) const {
    scene.format = halves_ ? "hier, halves" : "hier, floats";
    scene.levels = {levels_, node_count_, leaves_.size(), merged_};
    if (const std::uint64_t unnamed = count_ - leaves_.size() - merged_; unnamed > 0)
      scene.warn("{} Gaussians belong to no node of its tree and were left out.", unnamed);
    if (cursor_.left() > 0) scene.warn("{} bytes after the boxes were ignored.", cursor_.left());
  }

 private:
  // Checks node `i`, marks its Gaussians in `named` and keeps its leaves.
  LodChildren take_node(std::uint64_t i, std::vector<bool>& named) {
    const Node node = parse_node(nodes_.data() + i * layout_.node, halves_);
    if (node.children < 0 || (node.children > 0 && node.first_child < 0))
      fail("{}: node {} has {} children from node {} on", path_, i, node.children,
           node.first_child);
    if (node.start < 0 || node.leaves < 0 || node.merged < 0 ||
        node.start + node.leaves + node.merged > static_cast<std::int64_t>(count_))
      fail("{}: node {} names {} leaves and {} merged Gaussians from {} on of {}", path_, i,
           node.leaves, node.merged, node.start, count_);
    for (std::int64_t k = 0; k < node.leaves + node.merged; ++k) {
      const auto row = static_cast<std::size_t>(node.start + k);
      if (named[row]) fail("{}: Gaussian {} belongs to two nodes of its tree", path_, row);
      named[row] = true;
      if (k < node.leaves) leaves_.push_back(static_cast<std::uint32_t>(row));
    }
    merged_ += static_cast<std::uint64_t>(node.merged);
    return {static_cast<std::uint64_t>(node.first_child),
            static_cast<std::uint64_t>(node.children)};
  }

  std::string path_;
  ByteCursor cursor_;
  bool halves_ = false;
  Layout layout_{};
  std::uint64_t count_ = 0, node_count_ = 0, merged_ = 0;
  ByteSpan positions_, rotations_, scales_, alphas_, sh_, nodes_;
  std::uint32_t levels_ = 0;
  std::vector<std::uint32_t> leaves_;  // rows of Gaussians
};

}  // namespace

bool recognises_hier(ByteSpan content, const std::filesystem::path&) {
  if (content.size() < 8) return false;
  const std::int64_t count = load<std::int32_t>(content.data());
  const Layout& layout = count < 0 ? kHalves : kFloats;
  const std::uint64_t row = 3 * sizeof(float) + (4 + 3 + 1 + kShValues) * layout.number;
  const std::uint64_t rows = row * static_cast<std::uint64_t>(count < 0 ? -count : count);
  if (rows == 0 || rows > content.size() - 8) return false;
  const auto nodes = load<std::int32_t>(content.data() + 4 + rows);
  return nodes > 0 && content.size() - 8 - rows ==
                          (layout.node + layout.box) * static_cast<std::uint64_t>(nodes);
}

void read_hier(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
               const ReadOptions& options, Scene& scene) {
  const HierFile file(content, path.string());
  scene.cloud = make_cloud(file.leaves().size(), 3);
  LinearValues linear;
  fill_cloud(scene, pool, options.progress, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) file.fill(scene.cloud, k, linear);
  });
  linear.warn(scene);
  file.describe(scene);
}

}  // namespace qs
