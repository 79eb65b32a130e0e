// SPDX-License-Identifier: MIT
#include "learn/lod/section.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include "base/fail.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/cloud_memory.h"
#include "learn/lod/cut.h"
#include "raster/kernel/constants.h"
#include "raster/kernel/half.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/transform.h"

namespace qs {
namespace {

// Sets a merged node's Gaussian as viewers without filters draw it, and its facts.
void draw(const LodGaussian& gaussian, const NodeLevels& levels, float footprint, LodNode& node) {
  const DrawnLod shown = drawn(gaussian, 0);
  const LodCovariance& c = shown.covariance;
  glm::dmat3 axes;
  glm::dvec3 variances;
  diagonalise(glm::dmat3(c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5]), axes, variances);
  if (glm::determinant(axes) < 0) axes[0] = -axes[0];
  node.center = gaussian.mean;
  node.rotation = glm::quat(glm::normalize(glm::quat_cast(axes)));
  node.scales = glm::sqrt(glm::max(variances, glm::dvec3(0)));
  node.alpha = shown.opacity;
  const float area = ellipsoid_area(gaussian.covariance);
  node.layers = area > 0 ? gaussian.mass / area : 0;
  node.opacities = gaussian.opacities;
  // The Gaussian may reach farther than the centres of its leaves.
  node.radius =
      std::max(levels.radius, 3 * std::max({node.scales.x, node.scales.y, node.scales.z}));
  node.gains = levels.gains;
  for (std::size_t k = 0; k < kLodFootprints; ++k)
    node.errors[k] = lod_step(levels.errors[k], footprint);
}

template <class T>
void put(std::ostream& stream, const std::vector<T>& values) {
  const std::uint64_t count = values.size();
  stream.write(reinterpret_cast<const char*>(&count), sizeof count);
  stream.write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(count * sizeof(T)));
}

template <class T>
void get(std::istream& stream, std::vector<T>& values) {
  std::uint64_t count = 0;
  stream.read(reinterpret_cast<char*>(&count), sizeof count);
  values.resize(stream ? count : 0);
  stream.read(reinterpret_cast<char*>(values.data()),
              static_cast<std::streamsize>(count * sizeof(T)));
}

// The arrays of a section in the order of its file.
template <class Section, class Visit>
void for_each_array(Section& section, bool roots_only, const Visit& visit) {
  visit(section.roots.gaussians);
  visit(section.roots.levels);
  for (auto* const nodes : {&section.roots.drawn, &section.tree}) {
    if (roots_only && nodes == &section.tree) break;
    visit(nodes->nodes);
    visit(nodes->sh);
    visit(nodes->original);
  }
}

}  // namespace

LodGaussian item_of(const GaussianCloud& cloud, std::size_t i) {
  LodGaussian item;
  item.mean = cloud.positions[i];
  const Covariance3<double> c = world_covariance(cloud, i);
  const std::array<double, 6> values{c.xx, c.xy, c.xz, c.yy, c.yz, c.zz};
  std::ranges::transform(values, item.covariance.begin(),
                         [](double v) { return static_cast<float>(v); });
  set_opacity(item, static_cast<float>(opacity_of_logit(cloud.opacity_logits[i])));
  const glm::vec3* const sh = sh_of(cloud, i);
  for (std::size_t k = 0; k < kLodColors && k < 3 * sh_count(cloud); ++k)
    item.color[k] = static_cast<float>(kSh0) * sh[k / 3][static_cast<int>(k % 3)];
  return item;
}

void LodItems::add(const GaussianCloud& cloud, std::size_t i, const LodFacts& facts,
                   float footprint) {
  LodGaussian item = item_of(cloud, i);
  LodNode node{facts};
  node.center = cloud.positions[i];
  node.scales = glm::exp(cloud.log_scales[i]);
  node.rotation = cloud.rotations[i];
  node.alpha = item.opacities;
  NodeLevels own{.gains = facts.gains, .radius = facts.radius};
  if (facts.child_count > 0) {
    const LodGaussian merged = merged_node(cloud, i, facts);
    item.covariance = merged.covariance;
    item.mass = merged.mass;
    item.opacities = merged.opacities;
    item.is_leaf = false;
    for (std::size_t k = 0; k < kLodFootprints; ++k)
      own.errors[k] = lod_value(facts.errors[k], footprint);
  }
  gaussians.push_back(item);
  levels.push_back(own);
  drawn.nodes.push_back(node);
  for (const glm::vec3* sh = sh_of(cloud, i); sh != sh_of(cloud, i) + sh_count(cloud); ++sh)
    for (int channel = 0; channel < 3; ++channel) drawn.sh.push_back(nearest_half((*sh)[channel]));
}

void LodItems::append(const LodItems& other) {
  const auto add = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  add(gaussians, other.gaussians);
  add(levels, other.levels);
  drawn.append(other.drawn, 0, other.size());
}

LodSection make_section(LodItems items, std::size_t roots, const SectionOptions& options) {
  const std::size_t count = items.size(), values = items.drawn.sh.size() / count;
  const PairForest forest = merge_pairs(std::move(items.gaussians), roots, options.antialiased);
  const std::vector<NodeLevels> levels =
      levels_of(forest, std::move(items.levels), options.footprint, options.antialiased);
  const FlatForest flat = flattened(forest, levels);
  // SH of the merged nodes, by the shares of their pairs.
  std::vector<float> merged_sh(forest.children.size() * values);
  std::array<std::vector<float>, 2> rows;  // of items
  for (std::size_t i = 0; i < forest.children.size(); ++i) {
    std::array<const float*, 2> sh;
    for (std::size_t c = 0; c < 2; ++c) {
      const std::size_t child = forest.children[i][c];
      sh[c] = child < count ? nullptr : &merged_sh[(child - count) * values];
      if (sh[c] != nullptr) continue;
      rows[c].resize(values);
      std::transform(&items.drawn.sh[child * values], &items.drawn.sh[child * values] + values,
                     rows[c].begin(), float_of_half);
      sh[c] = rows[c].data();
    }
    const auto [a, b] = forest.children[i];
    const float p = share_of(forest.nodes[a], forest.nodes[b]);
    std::transform(sh[0], sh[0] + values, sh[1], &merged_sh[i * values],
                   [p](float x, float y) { return p * x + (1 - p) * y; });
  }
  LodSection section;
  RadNodes& tree = section.tree;
  tree.nodes.resize(flat.nodes.size());
  tree.sh.resize(flat.nodes.size() * values);
  section.items.resize(flat.nodes.size(), ~0u);
  std::vector<std::size_t> leaves(count + 1);  // among the items before
  for (std::size_t i = 0; i < count; ++i)
    leaves[i + 1] = leaves[i] + (items.drawn.nodes[i].child_count == 0 ? 1 : 0);
  const auto original_of = [&, at = items.drawn.original.begin()](std::size_t leaf) {
    return at + static_cast<std::ptrdiff_t>(leaf * items.drawn.original.size() /
                                            std::max<std::size_t>(leaves.back(), 1));
  };
  for (std::size_t i = 0; i < flat.nodes.size(); ++i) {
    const FlatForest::Node& from = flat.nodes[i];
    LodNode& node = tree.nodes[i];
    if (from.number < count) {
      node = items.drawn.nodes[from.number];
      section.items[i] = from.number;
      tree.original.insert(tree.original.end(), original_of(leaves[from.number]),
                           original_of(leaves[from.number + 1]));
      std::copy_n(&items.drawn.sh[from.number * values], values, &tree.sh[i * values]);
    } else {
      draw(forest.nodes[from.number], levels[from.number], options.footprint, node);
      node.first_child = from.first_child;
      node.child_count = static_cast<std::uint16_t>(from.child_count);
      const float* const sh = &merged_sh[(from.number - count) * values];
      std::transform(sh, sh + values, &tree.sh[i * values], nearest_half);
    }
    node.parent = from.parent;
    if (i >= forest.roots.size()) continue;
    section.roots.gaussians.push_back(forest.nodes[from.number]);
    section.roots.levels.push_back(levels[from.number]);
  }
  section.roots.drawn.append(tree, 0, forest.roots.size());
  return section;
}

void write_section(const std::filesystem::path& path, const LodSection& section) {
  write_file(path, [&](std::ostream& stream) {
    const std::uint64_t nodes = section.tree.nodes.size();
    stream.write(reinterpret_cast<const char*>(&nodes), sizeof nodes);
    for_each_array(section, false, [&](const auto& values) { put(stream, values); });
  });
}

std::uint64_t section_nodes(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::uint64_t nodes = 0;
  stream.read(reinterpret_cast<char*>(&nodes), sizeof nodes);
  return nodes;
}

LodSection read_section(const std::filesystem::path& path, bool roots_only) {
  std::ifstream stream(path, std::ios::binary);
  stream.seekg(sizeof(std::uint64_t));
  LodSection section;
  for_each_array(section, roots_only, [&](auto& values) { get(stream, values); });
  if (!stream) fail("{}: cannot be read: it was cut off or removed during the work", path.string());
  return section;
}

}  // namespace qs
